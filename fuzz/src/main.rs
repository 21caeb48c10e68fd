//! One target under libFuzzer: `CREASE_FUZZ_TARGET` names it, the arguments are libFuzzer's own.
#![no_main]

use crease_fuzz::allocation::Counted;
use crease_fuzz::{Part, Target, target};
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use std::sync::LazyLock;

#[global_allocator]
static ALLOCATOR: Counted = Counted;

static TARGET: LazyLock<&'static Target> = LazyLock::new(|| {
    let name = std::env::var("CREASE_FUZZ_TARGET").unwrap_or_default();
    target(&name).unwrap_or_else(|| panic!("CREASE_FUZZ_TARGET: expected the name of a target, found {name:?}"))
});

fuzz_target!(|bytes: &[u8]| (TARGET.check)(bytes));

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    // One mutation in four is blind, outer form and all.
    let parts = TARGET.container.filter(|_| seed % 4 != 0).and_then(|container| {
        let parts = (container.open)(&data[..size])?;
        Some((container, parts))
    });
    let Some((container, mut parts)) = parts else { return fuzzer_mutate(data, size, max_size) };
    let index = seed as usize / 4 % parts.len();
    mutate(&mut parts[index], max_size);
    let bytes = (container.close)(&parts);
    if bytes.len() > max_size {
        return size;
    }
    data[..bytes.len()].copy_from_slice(&bytes);
    bytes.len()
});

fn mutate(part: &mut Part, max_size: usize) {
    let size = part.bytes.len();
    part.bytes.resize(max_size.max(size), 0);
    let size = fuzzer_mutate(&mut part.bytes, size, max_size.max(size));
    part.bytes.truncate(size);
}
