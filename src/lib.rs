//! gradtess
pub mod mesh;
pub mod patch;
pub mod scene;
pub mod subdiv;
