//! Tables and figures of ZHHK22.

pub mod fig_18;
pub mod fig_20;
pub mod table_1;
pub mod timing;
