//! robot_model
