use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a body weighs: in the frame of its link (`describe` has the table), or in the flange's.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmInertia {
    /// Its mass.
    #[schema(exclusive_minimum = 0, maximum = 1_000_000)]
    pub mass_kg: f64,
    /// Its center of mass.
    pub center_of_mass_m: [f64; 3],
    /// The matrix of its inertia about the center of mass, along the frame's axes, as a list of rows. A payload may be
    /// without: then only its mass counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia_kg_m2: Option<[[f64; 3]; 3]>,
}

/// A motion of an arm, of which the joints' torques are asked for.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "joints_deg_mm": [0, 20, -20, 0, -70, 0],
    "velocities_deg_mm_s": [30, 0, 0, 0, 0, 90],
    "accelerations_deg_mm_s2": [0, 60, 0, 0, 0, 0],
    "payload": {"mass_kg": 5, "center_of_mass_m": [0, 0, 0.1]},
    "links": [
        {"mass_kg": 80, "center_of_mass_m": [-0.1, -0.15, 0], "inertia_kg_m2": [[1.9, 0, 0], [0, 1.5, 0], [0, 0, 1.7]]},
        {"mass_kg": 45, "center_of_mass_m": [-0.4, 0, 0], "inertia_kg_m2": [[0.3, 0, 0], [0, 2.4, 0], [0, 0, 2.5]]},
        {"mass_kg": 50, "center_of_mass_m": [-0.1, 0, 0.1], "inertia_kg_m2": [[1.1, 0, 0], [0, 1.3, 0], [0, 0, 0.8]]},
        {"mass_kg": 18, "center_of_mass_m": [0, 0.25, 0], "inertia_kg_m2": [[0.9, 0, 0], [0, 0.2, 0], [0, 0, 0.8]]},
        {"mass_kg": 6, "center_of_mass_m": [0, 0, 0.04], "inertia_kg_m2": [[0.05, 0, 0], [0, 0.04, 0], [0, 0, 0.03]]},
        {"mass_kg": 1.5, "center_of_mass_m": [0, 0, -0.02], "inertia_kg_m2": [[0.004, 0, 0], [0, 0.003, 0], [0, 0, 0.005]]}
    ]
}))]
pub struct ArmInverseDynamicsBody {
    /// The joints, base first.
    pub joints_deg_mm: Vec<f64>,
    /// Their velocities; 0 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocities_deg_mm_s: Option<Vec<f64>>,
    /// Their accelerations; 0 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accelerations_deg_mm_s2: Option<Vec<f64>>,
    /// What is fixed to the flange, in the flange's frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<ArmInertia>,
    /// The free fall in the arm's world; 9.80665 m/s^2 along -Z where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity_m_s2: Option<[f64; 3]>,
    /// What the links weigh, base first, each with its inertia; the model's own where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub links: Option<Vec<ArmInertia>>,
}

/// Torques of joints that turn, in N m, and forces of joints that slide, in N; base first. They belong to the displayed
/// values: where a joint moves another's link too, its drive gives both.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ArmInverseDynamicsResult {
    /// What the drives have to give: the sum of the three below.
    pub torques_nm_n: Vec<f64>,
    /// What holds the arm still.
    pub gravity_nm_n: Vec<f64>,
    /// What the velocities take: centrifugal and Coriolis' forces.
    pub velocity_nm_n: Vec<f64>,
    /// What the accelerations take.
    pub acceleration_nm_n: Vec<f64>,
    /// The power of all joints; below 0 the arm gives it back.
    pub power_w: f64,
}
