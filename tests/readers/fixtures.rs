//! Files to read. `fixtures/pickles/make.py` says how the pickles were made.

use crease::numpy::{Array, Compression, write_npz};

macro_rules! pickles {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_bytes!(concat!("../fixtures/pickles/", $name)).as_slice())),*]
    };
}

/// The same arrays as Python 2 and 3, numpy 1 and 2 write them, in protocols 0 to 5.
pub const ARRAYS: [(&str, &[u8]); 13] = pickles![
    "arrays-python2-protocol0.pkl",
    "arrays-python2-protocol1.pkl",
    "arrays-python2-protocol2.pkl",
    "arrays-numpy1-protocol0.pkl",
    "arrays-numpy1-protocol2.pkl",
    "arrays-numpy1-protocol4.pkl",
    "arrays-numpy1-protocol5.pkl",
    "arrays-numpy2-protocol0.pkl",
    "arrays-numpy2-protocol1.pkl",
    "arrays-numpy2-protocol2.pkl",
    "arrays-numpy2-protocol3.pkl",
    "arrays-numpy2-protocol4.pkl",
    "arrays-numpy2-protocol5.pkl",
];

/// The same motion in AIST++'s layout.
pub const MOTIONS: [(&str, &[u8]); 3] = pickles!["motion-python2.pkl", "motion-numpy1.pkl", "motion-numpy2.pkl"];

/// A body with the types of SMPL's own file: chumpy wrappers, a sparse regressor, unsigned parents.
pub const BODY: (&str, &[u8]) = pickles!["body-python2.pkl"][0];

/// Named arrays that tests change before they write them.
#[derive(Clone)]
pub struct Arrays(pub Vec<(&'static str, Array)>);

impl Arrays {
    pub fn with(mut self, name: &'static str, array: Array) -> Self {
        self.0.retain(|(other, _)| *other != name);
        self.0.push((name, array));
        self
    }

    pub fn without(mut self, name: &str) -> Self {
        self.0.retain(|(other, _)| *other != name);
        self
    }

    pub fn get(&self, name: &str) -> &Array {
        &self.0.iter().find(|(other, _)| *other == name).expect("an array of this name").1
    }

    pub fn npz(&self) -> Vec<u8> {
        let arrays: Vec<(&str, &Array)> = self.0.iter().map(|(name, array)| (*name, array)).collect();
        write_npz(&arrays, Compression::Deflated).expect("distinct names")
    }
}

/// SMPL's parents, the root's as SMPL's file has it.
pub const PARENTS: [i64; 24] =
    [4294967295, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21];

/// A body of 24 vertices, vertex j being joint j.
pub fn body() -> Arrays {
    let identity: Vec<f64> = (0..24 * 24).map(|at| if at % 25 == 0 { 1.0 } else { 0.0 }).collect();
    Arrays(vec![
        ("v_template", Array::new(&[24, 3], (0..72).map(|n| n as f32 / 100.0).collect::<Vec<_>>())),
        ("f", Array::new(&[2, 3], vec![0i64, 1, 2, 21, 22, 23])),
        ("shapedirs", Array::new(&[24, 3, 2], (0..144).map(f64::from).collect::<Vec<_>>())),
        ("J_regressor", Array::new(&[24, 24], identity.clone())),
        ("weights", Array::new(&[24, 24], identity)),
        ("kintree_table", Array::new(&[2, 24], PARENTS.into_iter().chain(0..24).collect::<Vec<_>>())),
    ])
}

/// Frames of `width` axis-angle numbers; number n of frame t is t/10 + n/1000.
pub fn angles(frames: usize, width: usize) -> Array {
    let at = |i: usize| (i / width) as f32 / 10.0 + (i % width) as f32 / 1000.0;
    Array::new(&[frames, width], (0..frames * width).map(at).collect::<Vec<_>>())
}

/// A motion in AMASS's layout.
pub fn motion(frames: usize, width: usize) -> Arrays {
    Arrays(vec![
        ("poses", angles(frames, width)),
        ("trans", Array::new(&[frames, 3], (0..3 * frames).map(|n| n as f64).collect::<Vec<_>>())),
        ("mocap_framerate", Array::new(&[], vec![120.0f64])),
    ])
}
