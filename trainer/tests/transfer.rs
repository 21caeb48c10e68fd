//! `crease transfer` and `crease texture`, as their users call them.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::Directory;
use crease::avatar::Avatar;
use crease::fixture::{compact_avatar, plain_avatar};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn succeeds(directory: &Path, arguments: &[&str]) {
    let output = crease(directory, arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn crease(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_crease")).args(arguments).current_dir(directory).output().unwrap()
}

fn avatars(name: &str) -> (Directory, Avatar, Avatar) {
    let directory = Directory::new(name);
    let (mut a, b) = (plain_avatar(), plain_avatar());
    a.name = "a".into();
    a.laplacian = compact_avatar().laplacian;
    a.form = compact_avatar().form;
    let texture = a.appearance.texture.as_mut().unwrap();
    // Viewers stop where a picture ends.
    texture.bytes.extend([0; 4]);
    for (name, avatar) in [("a.glb", &a), ("b.glb", &b), ("bare.glb", &compact_avatar())] {
        fs::write(directory.0.join(name), avatar.write()).unwrap();
    }
    (directory, a, b)
}

fn read(directory: &Path, name: &str) -> Avatar {
    Avatar::read(&fs::read(directory.join(name)).unwrap(), name).unwrap()
}

#[test]
fn wrinkles_and_textures_change_hands() {
    let (directory, a, b) = avatars("transfer");
    let directory = &directory.0;
    succeeds(directory, &["transfer", "--detail", "a.glb", "--base", "b.glb", "-o", "c.glb"]);
    let made = read(directory, "c.glb");
    assert_eq!((&made.laplacian, made.form), (&a.quantised().laplacian, a.form));
    assert_eq!((&made.deformation, &made.appearance), (&b.quantised().deformation, &b.appearance));
    assert_eq!(made.provenance["detail_from"]["name"], "a");

    succeeds(directory, &["texture", "--from", "a.glb", "--onto", "b.glb", "-o", "d.glb"]);
    let made = read(directory, "d.glb");
    assert_eq!(made.appearance.texture, a.appearance.texture);
    assert_eq!(made.laplacian, b.quantised().laplacian);
    assert_eq!(made.provenance["texture_from"]["name"], "a");
}

#[test]
fn what_cannot_be_taken_is_named_and_nothing_is_written() {
    let (directory, ..) = avatars("no-transfer");
    let output = crease(&directory.0, &["texture", "--from", "bare.glb", "--onto", "b.glb", "-o", "d.glb"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && said.contains("bare.glb: texture: expected one, found none"), "{said}");
    assert!(!directory.0.join("d.glb").exists());
}
