//! Every choice of training, in one place: for the command line, for files and for code. A preset is a value of [`TrainOptions`].

use crate::compact::CompactOptions;
use crate::refinement::RefinementOptions;
use crate::sequence::NEARNESS;
use crease::avatar::Form;
use crease::mesh::Scheme;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What the wanted Laplacian of a training frame is measured with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LaplacianTarget {
    /// Quadratic fits to the neighbourhoods of scan points (the paper's, after Liang & Zhao 2012).
    Quadratic,
    /// The reconstruction's own operator on the finest mesh fitted to the scan: δ = L x / s.
    Operator,
}

/// Form of the two surface functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FunctionForm {
    /// Multilayer perceptrons of γ(Q) and θ̄ (the paper's).
    Plain,
    /// Tables on vertices times coefficients of the pose.
    Compact,
}

/// Where multilayer perceptrons are trained. GPUs need the cargo feature of the same name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum ComputeDevice {
    /// The processor; the same seed gives the same numbers.
    Cpu,
    /// The first GPU that Vulkan offers, or Metal or DirectX 12 where there is no Vulkan.
    Vulkan,
    /// The first CUDA GPU.
    Cuda,
}

/// All options of training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainOptions {
    /// Seed of every random choice.
    pub seed: u64,
    /// How the base is subdivided.
    pub scheme: Scheme,
    /// How often; 2 makes sixteen triangles of one.
    pub level_count: u32,
    /// What f_l is relative to.
    pub form: Form,
    /// What f_l learns.
    pub target: LaplacianTarget,
    /// Form of f_d and f_l.
    pub function: FunctionForm,
    /// Where multilayer perceptrons are trained.
    pub device: ComputeDevice,
    /// Frequencies of the positional encoding γ.
    pub frequency_count: u32,
    /// Number of anchors.
    pub anchor_count: usize,
    /// w_a of the reconstruction.
    pub anchor_weight: f32,
    /// Width and height of the texture in texels; a power of two.
    pub texture_size: usize,
    /// How much of the training data of multilayer perceptrons is in memory at a time, MiB; the rest is read again when its turn comes. Of
    /// more points than fit, f_l is shown frames in random order, and the points of as many as fit shuffled.
    #[serde(default = "memory_mib")]
    pub memory_mib: usize,
    /// c of μ = exp(−c z) for points that a depth camera sees z metres away, 1/m (paper, below Eq. pose_dependent_offsets); 0 weighs all alike.
    #[serde(default = "nearness")]
    pub nearness: f32,
    /// Refinement of the poses.
    #[serde(default)]
    pub refinement: RefinementOptions,
    /// Training of f_d as a multilayer perceptron.
    pub deformation: DeformationOptions,
    /// Ground-truth Laplacians by quadratic fits.
    pub quadratic: QuadraticOptions,
    /// Which scan points are believed.
    pub localisation: LocalisationOptions,
    /// Training of f_l as a multilayer perceptron.
    pub laplacian: LaplacianOptions,
    /// Training in compact form.
    pub compact: CompactOptions,
}

/// Of runs that were written before there was a choice, and of new ones.
fn memory_mib() -> usize {
    2048
}

/// The same.
fn nearness() -> f32 {
    NEARNESS
}

/// Shape and optimiser of a multilayer perceptron.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkOptions {
    /// Linear layers, the last included.
    pub layer_count: usize,
    /// Channels of each hidden layer.
    pub width: usize,
    /// Adam's learning rate.
    pub learning_rate: f64,
    /// Passes over the training data.
    pub epoch_count: usize,
}

/// Training of f_d (paper Eqs. pose_dependent_offsets, base_reg, reliable_anchor).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeformationOptions {
    /// The network.
    pub network: NetworkOptions,
    /// Frames a step.
    pub frames_a_step: usize,
    /// Points of a frame used in a step, drawn anew each time; 0 uses all.
    pub points_a_frame: usize,
    /// λ_r, weight of the squared umbrella Laplacian of posed vertices.
    pub regulariser_weight: f32,
    /// λ_a, weight of the distance from anchors to the scan.
    pub anchor_weight: f32,
    /// Weight of the distance from every vertex to the scan; 0 leaves that direction out.
    pub mesh_to_scan_weight: f32,
}

/// Training of f_l (paper Eq. PDD).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaplacianOptions {
    /// The network.
    pub network: NetworkOptions,
    /// Points a step.
    pub points_a_step: usize,
}

/// Which points a quadratic is fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Neighbourhood {
    /// So many nearest points, the point itself included (20–30 in the paper).
    Nearest(usize),
    /// All points within so many metres.
    Radius(f32),
}

/// Ground-truth Laplacians by quadratic fits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuadraticOptions {
    /// Which points a quadratic is fitted to.
    pub neighbourhood: Neighbourhood,
    /// Longer Laplacians are shortened to this length, 1/m; infinity clamps nothing.
    pub clamp: f32,
}

/// Which scan points are believed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalisationOptions {
    /// Points farther from the base mesh are rejected, metres.
    pub greatest_distance: f32,
    /// Points whose normal line makes a smaller |cos| with the base mesh's normal are rejected.
    pub least_cosine: f32,
}

impl TrainOptions {
    /// Bytes of `memory_mib`.
    pub fn memory_bytes(&self) -> usize {
        self.memory_mib << 20
    }

    /// The paper to the letter. Meant for a GPU; narrower networks and fewer epochs run on a CPU.
    pub fn paper() -> Self {
        let network =
            |layer_count, width, epoch_count| NetworkOptions { layer_count, width, learning_rate: 1e-3, epoch_count };
        Self {
            seed: 0,
            scheme: Scheme::Midpoint,
            level_count: 2,
            form: Form::Absolute,
            target: LaplacianTarget::Quadratic,
            function: FunctionForm::Plain,
            device: ComputeDevice::Cpu,
            frequency_count: 10,
            anchor_count: 800,
            anchor_weight: 1.0,
            texture_size: 1024,
            memory_mib: memory_mib(),
            nearness: NEARNESS,
            refinement: RefinementOptions::default(),
            deformation: DeformationOptions {
                network: network(5, 600, 300),
                frames_a_step: 10,
                points_a_frame: 0,
                regulariser_weight: 1.0,
                anchor_weight: 2.0,
                mesh_to_scan_weight: 0.0,
            },
            quadratic: QuadraticOptions { neighbourhood: Neighbourhood::Nearest(25), clamp: 300.0 },
            localisation: LocalisationOptions { greatest_distance: 0.05, least_cosine: 0.5 },
            laplacian: LaplacianOptions { network: network(3, 800, 100), points_a_step: 5000 },
            compact: CompactOptions::default(),
        }
    }

    /// What a browser plays every frame: a Loop base, operator Laplacians in relative form, tables and kernels.
    pub fn compact() -> Self {
        Self {
            scheme: Scheme::Loop,
            form: Form::Relative,
            target: LaplacianTarget::Operator,
            function: FunctionForm::Compact,
            ..Self::paper()
        }
    }

    /// The options of a preset's name.
    pub fn preset(name: &str) -> Result<Self, OptionError> {
        match name {
            "compact" => Ok(Self::compact()),
            "paper" => Ok(Self::paper()),
            _ => Err(OptionError { expected: "the preset compact or paper".into(), found: name.into() }),
        }
    }

    /// Assignments, as [`Self::with`] takes them, that make these options of `other`.
    pub fn assignments_from(&self, other: &Self) -> Vec<String> {
        // By way of text, which has a number of 32 bits in its shortest form.
        let value = |options| serde_json::from_str(&serde_json::to_string(options).expect("options are plain data"));
        let [own, other]: [Value; 2] = [self, other].map(|options| value(options).expect("what was written is JSON"));
        let mut assignments = Vec::new();
        differences("", &own, &other, &mut assignments);
        assignments
    }

    /// The options with `assignment` (`key=value`, keys joined by dots as in `deformation.network.width=64`) applied.
    ///
    /// The value is JSON; a bare word is text.
    pub fn with(&self, assignment: &str) -> Result<Self, OptionError> {
        let error = |expected: &str, found: &str| OptionError { expected: expected.into(), found: found.into() };
        let (key, text) = assignment.split_once('=').ok_or_else(|| error("key=value", assignment))?;
        let mut options = serde_json::to_value(self).expect("options are plain data");
        let pointer = format!("/{}", key.trim().replace('.', "/"));
        let place = options.pointer_mut(&pointer).ok_or_else(|| error("the key of an option", key))?;
        *place = serde_json::from_str(text).unwrap_or_else(|_| text.into());
        serde_json::from_value(options)
            .map_err(|message| error(&format!("a value for {key}"), &format!("{text} ({message})")))
    }
}

/// `key=value` for each leaf of `own` that `other` has otherwise.
fn differences(key: &str, own: &Value, other: &Value, assignments: &mut Vec<String>) {
    match (own, other) {
        (Value::Object(own), Value::Object(other)) if own.keys().eq(other.keys()) => {
            for (name, value) in own {
                let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                differences(&key, value, &other[name], assignments);
            }
        }
        _ if own == other => {}
        (Value::String(text), _) => assignments.push(format!("{key}={text}")),
        _ => assignments.push(format!("{key}={own}")),
    }
}

/// Why an option cannot be set.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("option: expected {expected}, found {found}")]
pub struct OptionError {
    expected: String,
    found: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assignments_reach_every_depth() {
        let options = TrainOptions::paper();
        assert_eq!(options.with("deformation.network.width=64").unwrap().deformation.network.width, 64);
        assert_eq!(options.with("form=relative").unwrap().form, Form::Relative);
        let radius = options.with(r#"quadratic.neighbourhood={"radius": 0.02}"#).unwrap();
        assert_eq!(radius.quadratic.neighbourhood, Neighbourhood::Radius(0.02));
        assert_eq!(options.with("seed=5").unwrap(), TrainOptions { seed: 5, ..options });
    }

    #[test]
    fn wrong_assignments_are_named() {
        let options = TrainOptions::paper();
        for (text, part) in
            [("width=3", "width"), ("seed", "key=value"), ("seed=-1", "seed"), ("form=sideways", "sideways")]
        {
            let message = options.with(text).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn differences_are_the_assignments_that_make_them() {
        let paper = TrainOptions::paper();
        assert!(paper.assignments_from(&paper).is_empty());
        let assignments = [
            "compact.base_fit.smoothness=[3.0,1.0]",
            "deformation.network.width=64",
            "form=relative",
            r#"quadratic.neighbourhood={"radius":0.5}"#,
        ];
        let options = assignments.iter().fold(paper.clone(), |options, text| options.with(text).unwrap());
        assert_eq!(options.assignments_from(&paper), assignments);
        assert_eq!(TrainOptions::preset("paper").unwrap(), paper);
        assert!(TrainOptions::preset("papyrus").unwrap_err().to_string().contains("papyrus"));
    }

    #[test]
    fn presets_survive_json() {
        for options in [TrainOptions::paper(), TrainOptions::compact()] {
            let text = serde_json::to_string(&options).unwrap();
            assert_eq!(serde_json::from_str::<TrainOptions>(&text).unwrap(), options);
        }
    }
}
