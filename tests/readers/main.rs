//! Bodies, motions and arrays from files of every supported kind, whole and damaged.

mod body;
mod damage;
mod fixtures;
mod motion;
mod npz;
mod pickle;
