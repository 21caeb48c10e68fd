//! Files cut short, with flipped bits, or made of anything: an error or a sound result, never a panic.

use crate::fixtures::{ARRAYS, BODY, MOTIONS, body, motion};
use crate::npz::zip_with;
use crease::body::Body;
use crease::motion::Motion;
use crease::numpy::{Archive, ReadError};
use proptest::prelude::*;

/// Reads every field of an archive.
fn read_all(bytes: &[u8]) -> Result<(), ReadError> {
    let mut archive = Archive::open(bytes, "damaged")?;
    for name in archive.names() {
        let field = archive.optional(&name)?;
        field.map(|field| (field.finite_numbers(), field.indices(10, "ten"), field.single_number()));
    }
    Ok(())
}

fn read_motion(bytes: &[u8]) -> Result<(), ReadError> {
    let motion = Motion::read(bytes, "damaged", Some(30.0))?;
    let pose = motion.sample_looped(0.7 * motion.duration());
    assert!(pose.rotations.iter().all(|rotation| rotation.is_finite()));
    Ok(())
}

fn read_body(bytes: &[u8]) -> Result<(), ReadError> {
    let rig = Body::read(bytes, "damaged")?.shaped(&[1.0]);
    assert!(rig.rest_joints.len() >= 24);
    Ok(())
}

type Reader = fn(&[u8]) -> Result<(), ReadError>;

/// Small files of each kind and what reads them.
fn files() -> Vec<(Reader, Vec<u8>)> {
    let mut files: Vec<(Reader, Vec<u8>)> = vec![
        (read_motion, motion(2, 72).npz()),
        (read_body, body().npz()),
        (read_motion, MOTIONS[0].1.to_vec()),
        (read_body, BODY.1.to_vec()),
    ];
    files.extend(ARRAYS.map(|(_, bytes)| (read_all as Reader, bytes.to_vec())));
    files
}

#[test]
fn whole_files_are_read() {
    for (read, bytes) in &files()[..4] {
        read(bytes).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn files_cut_short_are_errors() {
    for (read, bytes) in files() {
        for length in (0..bytes.len()).step_by(3).chain([bytes.len() - 1]) {
            assert!(read(&bytes[..length]).is_err(), "cut to {length} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn flipped_bits_do_no_harm() {
    for (read, bytes) in files() {
        let mut refused = 0;
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << (at % 8);
            refused += usize::from(read(&damaged).is_err());
        }
        assert!(refused > 0, "a flipped bit can be noticed");
    }
}

/// Bytes that look like pickles: mostly opcodes and small arguments.
fn pickle_like() -> impl Strategy<Value = Vec<u8>> {
    let opcodes = b".()]}NKMJGIFLBCTUSXVabcdeghjlpqrstu012R\x80\x81\x85\x86\x87\x88\x89\x8a\x8b\x8c\x8e\x93\x94\x96";
    let piece = prop_oneof![
        6 => proptest::sample::select(opcodes.as_slice()).prop_map(|opcode| vec![opcode]),
        3 => any::<u8>().prop_map(|byte| vec![byte % 8]),
        1 => any::<u8>().prop_map(|byte| vec![byte]),
        2 => proptest::sample::select(vec![
            b"cnumpy.core.multiarray\n_reconstruct\n".to_vec(),
            b"cnumpy.core.multiarray\nscalar\n".to_vec(),
            b"cnumpy.core.numeric\n_frombuffer\n".to_vec(),
            b"cnumpy\ndtype\nU\x02f4\x85R".to_vec(),
            b"cscipy.sparse.csc\ncsc_matrix\n)\x81".to_vec(),
            b"cchumpy.ch\nCh\n)\x81".to_vec(),
            b"U\x01x".to_vec(),
            b"U\x05poses".to_vec(),
        ]),
    ];
    proptest::collection::vec(piece, 0..60).prop_map(|pieces| {
        let mut bytes = b"\x80\x02}U\x05poses".to_vec();
        bytes.extend(pieces.concat());
        bytes.extend(b"s.");
        bytes
    })
}

proptest! {
    #[test]
    fn arbitrary_bytes_are_errors_at_worst(
        start in proptest::sample::select(vec![
            b"".to_vec(), b"\x80\x04".to_vec(), b"(".to_vec(), b"}".to_vec(), b"PK\x03\x04".to_vec(),
        ]),
        rest in proptest::collection::vec(any::<u8>(), 0..400),
    ) {
        let bytes = [start, rest].concat();
        for read in [read_all, read_motion, read_body] {
            let _ = read(&bytes);
        }
    }

    #[test]
    fn arbitrary_arrays_in_an_archive_are_errors_at_worst(
        header in "\\{'descr': '[<>|]?[fiubSUO][0-9]{1,2}', 'fortran_order': (True|False), 'shape': \\([0-9, L]{0,12}\\), ?\\} *\n?",
        data in proptest::collection::vec(any::<u8>(), 0..80),
    ) {
        let mut npy = b"\x93NUMPY\x01\x00".to_vec();
        npy.extend((header.len() as u16).to_le_bytes());
        npy.extend(header.bytes());
        npy.extend(data);
        let _ = read_all(&zip_with("poses.npy", &npy));
        let _ = read_motion(&zip_with("poses.npy", &npy));
    }

    #[test]
    fn arbitrary_opcodes_are_errors_at_worst(bytes in pickle_like()) {
        let _ = read_all(&bytes);
        let _ = read_motion(&bytes);
    }
}
