//! Tables and figures of ZHHK22.

pub mod accuracy;
pub mod drag;
pub mod equal_error;
pub mod fig_11;
pub mod fig_13;
pub mod fig_18;
pub mod fig_19;
pub mod fig_20;
pub mod fig_21;
pub mod fig_22;
pub mod fig_4;
pub mod fig_5;
pub mod fig_6;
pub mod fig_7;
pub mod fig_8;
pub mod fig_9;
pub mod isolate;
pub mod pair;
pub mod pixels;
pub mod remap;
pub mod show;
pub mod table_1;
pub mod timing;
