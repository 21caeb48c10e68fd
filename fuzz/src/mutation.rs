//! Small changes of inputs, at random: bytes, numbers, blocks, words of other inputs; inside a container where there is one.

use crate::Container;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Numbers at whose edges code breaks.
const EDGES: [u64; 14] = [
    0,
    1,
    0x7f,
    0x80,
    0xff,
    0x7fff,
    0x8000,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fc0_0000,
    0x7fff_ffff_ffff_ffff,
    0xffff_ffff_ffff_ffff,
];

/// A changed copy of `input`, with parts of `other` now and then, of `longest` bytes at most. Three times out of four the container keeps its
/// form.
pub fn mutated(
    input: &[u8],
    other: &[u8],
    container: Option<Container>,
    longest: usize,
    random: &mut Pcg64Mcg,
) -> Vec<u8> {
    let opened = container.filter(|_| random.random_range(0..4) > 0).and_then(|container| {
        let parts = (container.open)(input)?;
        Some((container, parts))
    });
    let Some((container, mut parts)) = opened else { return changed(input, other, longest, random) };
    let other = (container.open)(other).unwrap_or_default();
    for _ in 0..=random.random_range(0..2) {
        let index = random.random_range(0..parts.len());
        let donor = other.get(random.random_range(0..other.len().max(1))).map_or(&[][..], |part| &part.bytes);
        parts[index].bytes = changed(&parts[index].bytes, donor, longest, random);
    }
    let bytes = (container.close)(&parts);
    if bytes.len() <= longest { bytes } else { input.to_vec() }
}

fn changed(input: &[u8], other: &[u8], longest: usize, random: &mut Pcg64Mcg) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..1 << random.random_range(0..5) {
        change(&mut bytes, other, random);
    }
    bytes.truncate(longest);
    bytes
}

fn change(bytes: &mut Vec<u8>, other: &[u8], random: &mut Pcg64Mcg) {
    let at = random.random_range(0..=bytes.len());
    let block = |bytes: &[u8], random: &mut Pcg64Mcg| {
        let start = random.random_range(0..=bytes.len());
        let length = random.random_range(0..=(bytes.len() - start).min(64));
        bytes[start..start + length].to_vec()
    };
    match random.random_range(0..9) {
        0 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
        1 if at < bytes.len() => bytes[at] = random.random(),
        2 if at < bytes.len() => bytes[at] = bytes[at].wrapping_add(random.random_range(0..32)).wrapping_sub(16),
        3 => {
            let edge =
                EDGES[random.random_range(0..EDGES.len())].wrapping_add(random.random_range(0..3)).wrapping_sub(1);
            let size = [1, 2, 4, 8][random.random_range(0..4)];
            let number = edge.to_le_bytes();
            bytes.iter_mut().skip(at).zip(&number[..size]).for_each(|(byte, edge)| *byte = *edge);
        }
        4 => {
            let end = at + random.random_range(0..=(bytes.len() - at).min(64));
            bytes.drain(at..end);
        }
        5 => {
            let copied = block(bytes, random);
            bytes.splice(at..at, copied);
        }
        6 => {
            let foreign = block(other, random);
            bytes.splice(at..at, foreign);
        }
        7 => {
            let foreign = block(other, random);
            bytes.iter_mut().skip(at).zip(foreign).for_each(|(byte, foreign)| *byte = foreign);
        }
        _ => {
            // A number in text, grown or shrunk.
            let digits = bytes.iter().skip(at).position(u8::is_ascii_digit);
            if let Some(start) = digits.map(|offset| at + offset) {
                let length = bytes[start..].iter().take_while(|byte| byte.is_ascii_digit()).count();
                let number = EDGES[random.random_range(0..EDGES.len())].to_string();
                bytes.splice(start..start + length, number.into_bytes());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn inputs_change_and_stay_within_their_length() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let input: Vec<u8> = (0..100).collect();
        let mutants: Vec<Vec<u8>> =
            (0..1000).map(|_| mutated(&input, b"another input 123", None, 120, &mut random)).collect();
        assert!(mutants.iter().all(|mutant| mutant.len() <= 120));
        assert!(mutants.iter().filter(|mutant| **mutant != input).count() > 900);
        // From nothing too.
        assert!((0..100).any(|_| !mutated(b"", b"abc", None, 9, &mut random).is_empty()));
    }

    #[test]
    fn containers_keep_their_form() {
        let mut random = Pcg64Mcg::seed_from_u64(2);
        for target in &crate::TARGETS {
            let Some(container) = target.container else { continue };
            let seed = (target.seeds)().swap_remove(0);
            let whole = (0..200)
                .map(|_| mutated(&seed, &seed, target.container, 1 << 16, &mut random))
                .filter(|mutant| (container.open)(mutant).is_some())
                .count();
            assert!(whole > 120, "{}: {whole} of 200 open", target.name);
        }
    }
}
