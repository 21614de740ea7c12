//! gradtess
pub mod check;
pub mod command;
pub mod gpu;
pub mod image;
pub mod mesh;
pub mod patch;
pub mod refine;
pub mod scene;
pub mod subdiv;
