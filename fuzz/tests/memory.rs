//! Memory that readers take: bounded by the file's size, bombs included.

use crease::avatar::Avatar;
use crease::body::Body;
use crease::memory::MemoryLimit;
use crease::motion::Motion;
use crease::numpy::Archive;
use crease_fuzz::TARGETS;
use crease_fuzz::allocation::{Counted, allowance, peak};
use crease_fuzz::containers::packed_png;
use crease_trainer::scan_file::decode_scan;
use crease_trainer::sequence::{Camera, ImageFile, decode_frame};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::{Cursor, Write};
use std::sync::{Mutex, PoisonError};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

#[global_allocator]
static ALLOCATOR: Counted = Counted;

/// Tests of one process share the count.
static ALONE: Mutex<()> = Mutex::new(());

/// The result of reading `bytes`, after a check of what that took.
fn bounded<T>(bytes: &[u8], read: impl FnOnce() -> T) -> T {
    let (result, peak) = peak(read);
    assert!(peak <= allowance(bytes.len()), "{peak} bytes for a file of {}", bytes.len());
    result
}

/// An archive of one array of `count` zeros.
fn bomb(name: &str, descr: &str, size: usize, shape: &str, count: usize) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    add_zeros(&mut zip, name, descr, size, shape, count);
    zip.finish().unwrap().into_inner()
}

fn add_zeros(zip: &mut ZipWriter<Cursor<Vec<u8>>>, name: &str, descr: &str, size: usize, shape: &str, count: usize) {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    zip.start_file(format!("{name}.npy"), options).unwrap();
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}\n");
    zip.write_all(b"\x93NUMPY\x01\x00").unwrap();
    zip.write_all(&(header.len() as u16).to_le_bytes()).unwrap();
    zip.write_all(header.as_bytes()).unwrap();
    let block = vec![0; 1 << 20];
    let mut left = count * size;
    while left > 0 {
        let length = left.min(block.len());
        zip.write_all(&block[..length]).unwrap();
        left -= length;
    }
}

#[test]
fn the_counter_counts() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let (_, small) = peak(|| std::hint::black_box(vec![0u8; 1 << 10]).len());
    let (_, large) = peak(|| std::hint::black_box(vec![0u8; 100 << 20]).len());
    assert!(small < 1 << 20 && (100 << 20..101 << 20).contains(&large), "{small} and {large}");
}

#[test]
fn bombs_are_refused_before_they_unfold() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    for (descr, size, count) in
        [("<f4", 4, 60_000_000), ("|u1", 1, 60_000_000), ("<f8", 8, 30_000_000), ("<i4", 4, 20_000_000)]
    {
        let bytes = bomb("poses", descr, size, &format!("{count},"), count);
        assert!(bytes.len() < 1 << 20);
        let error = bounded(&bytes, || Archive::open(&bytes, "bomb").unwrap().required("poses")).unwrap_err();
        assert!(error.field == "poses" && error.expected.contains("bytes in memory"), "{error}");
        let error = bounded(&bytes, || Motion::read(&bytes, "bomb", Some(30.0))).unwrap_err();
        assert!(error.expected.contains("bytes in memory"), "{error}");
    }
}

#[test]
fn many_small_bombs_are_one_large_one() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let count = 3 * 200_000;
    add_zeros(&mut zip, "v_template", "<f4", 4, "200000, 3", count);
    add_zeros(&mut zip, "f", "<u1", 1, "1, 3", 3);
    add_zeros(&mut zip, "shapedirs", "<f2", 2, "200000, 3, 20", 20 * count);
    let bytes = zip.finish().unwrap().into_inner();
    bounded(&bytes, || Body::read(&bytes, "bomb")).unwrap_err();
}

#[test]
fn limits_can_be_set() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let count = 72 * 100_000;
    let bytes = bomb("poses", "<f4", 4, "100000, 72", count);
    let read = |limit| Motion::read_within(&bytes, "long", Some(30.0), limit);
    assert!(read(MemoryLimit::default()).is_err());
    let motion = read(MemoryLimit { plus: 1 << 30, ..MemoryLimit::default() }).unwrap();
    assert_eq!(motion.poses.len(), 100_000);
    assert!(read(MemoryLimit { times_file: 0, plus: 100 }).is_err());
}

/// A pickle of one opcode over and over.
#[test]
fn pickles_of_nothing_but_opcodes_stay_small() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    for (start, repeated) in [
        (b"\x80\x04(".as_slice(), b"N".as_slice()),
        (b"\x80\x04", b"("),
        (b"\x80\x04N", b"\x94"),
        (b"\x80\x04Nq\x00", b"h\x00"),
        (b"\x80\x04N", b"2"),
        (b"\x80\x04", b"]"),
        (b"\x80\x04}", b"NN\x86"),
        (b"\x80\x04]", b"Na"),
        (b"\x80\x04}", b"NNs"),
        (b"\x80\x02cnumpy\ndtype\nq\x00)q\x010", b"h\x00h\x01R"),
    ] {
        let bytes = [start, &repeated.repeat((8 << 20) / repeated.len())].concat();
        assert!(bounded(&bytes, || Archive::open(&bytes, "opcodes").map(drop)).is_err(), "{repeated:?}");
    }
    // A sparse matrix of zeros, and an array that many names share.
    let dense = b"\x80\x02}U\x01acscipy.sparse.csr\ncsr_matrix\n)\x81}U\x06_shapeM\xff\xffK\x7f\x86sbs.";
    bounded(dense, || Archive::open(dense, "sparse").unwrap().required("a").map(drop)).unwrap_err();
}

#[test]
fn large_scans_stay_within_the_bound_or_are_refused() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    const BYTES: usize = 24 << 20;
    let file = |header: String, line: &[u8]| [header.as_bytes(), &line.repeat(BYTES / line.len())].concat();
    let ply = |kind: &str, properties: &str, line: &[u8]| {
        let count = BYTES / line.len();
        file(format!("ply\nformat {kind} 1.0\nelement vertex {count}\n{properties}end_header\n"), line)
    };
    let xyz = |kind: &str| ["x", "y", "z"].map(|axis| format!("property {kind} {axis}\n")).concat();
    let files = [
        ("ply", ply("ascii", &xyz("float"), b"1 0 0\n")),
        ("ply", ply("binary_little_endian", &xyz("char"), &[1; 3])),
        ("ply", ply("binary_big_endian", &xyz("double"), &[0; 24])),
        ("ply", ply("binary_little_endian", &(xyz("char") + "property list uchar uchar more\n"), &[1, 1, 1, 0])),
        ("obj", file(String::new(), b"v 1 0 0\n")),
        ("obj", file("v 0 0 0\nv 1 0 0\nv 0 1 0\n".into(), b"f 1 2 3\n")),
        ("obj", file("v 0 0 0\nv 1 0 0\nv 0 1 0\n".into(), b"f 1 2 3 1 2 3 1 2 3\n")),
        ("obj", file("v 0 0 0\n".into(), b"\n")),
    ];
    for (ending, bytes) in &files {
        match bounded(bytes, || decode_scan(bytes, ending, "large")) {
            Ok(cloud) => assert!(!cloud.points.is_empty()),
            Err(error) => assert!(error.expected.contains("bytes in memory"), "{ending}: {error}"),
        }
    }
    // And what such a limit is for is not refused: a scan of half a million points.
    let usual = ply("binary_little_endian", &xyz("float"), &[0; 12]);
    assert_eq!(bounded(&usual, || decode_scan(&usual, "ply", "usual")).unwrap().points.len(), BYTES / 12);
}

#[test]
fn pictures_unfold_no_further_than_their_files_allow() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    const SIZE: u32 = 12_000;
    let camera = format!(r#"{{"width": {SIZE}, "height": {SIZE}, "fx": 100, "fy": 100, "cx": 50, "cy": 50}}"#);
    let camera = Camera::decode(camera.as_bytes(), "camera.json").unwrap();
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::best());
    let row = vec![0; 1 + 2 * SIZE as usize];
    (0..SIZE).for_each(|_| packed.write_all(&row).unwrap());
    let size = SIZE.to_be_bytes();
    let picture = packed_png(&[&size[..], &size, &[16, 0, 0, 0, 0]].concat(), &packed.finish().unwrap());
    assert!(picture.len() < 1 << 20, "{} bytes", picture.len());
    let image = ImageFile { name: "bomb.png", bytes: &picture };
    let error = bounded(&picture, || decode_frame(&camera, 0, image, None, MemoryLimit::default())).unwrap_err();
    assert!(error.expected.contains("bytes in memory"), "{error}");
}

#[test]
fn avatars_unfold_no_further_than_their_files_allow() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let file = include_bytes!("../../web/assets/shirt-dancer.glb");
    let avatar = bounded(file, || Avatar::read(file, "shirt-dancer.glb")).unwrap();
    // Tables of zeros pack a thousandfold.
    let mut blank = avatar;
    let crease::network::SurfaceFunction::Compact(tables) = &mut blank.laplacian else { panic!("it has tables") };
    let rows = tables.row_vertices.len();
    let region = crease::network::Region {
        mask: tables.regions[0].mask,
        rows: (rows as u32, rows as u32 + 3_000_000),
        basis_count: 20,
        kernel_length: 1.0,
        coefficient_from_kernel: vec![0.0; 20 * tables.centre_count as usize],
        recalled: Vec::new(),
        fade: None,
    };
    tables.row_vertices.resize(rows + 3_000_000, 0);
    tables.mean.resize(3 * (rows + 3_000_000), 0.0);
    tables.basis.resize(tables.basis.len() + 60 * 3_000_000, 0);
    tables.basis_step.extend([1.0; 20]);
    tables.regions.push(region);
    let bomb = blank.write();
    assert!(bomb.len() < 8 << 20, "{} bytes", bomb.len());
    let error = bounded(&bomb, || Avatar::read(&bomb, "bomb.glb").map(drop)).unwrap_err();
    assert!(error.expected.contains("bytes in memory"), "{error}");
}

#[test]
fn seeds_and_what_was_found_stay_small() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    for target in &TARGETS {
        (target.seeds)().iter().for_each(|seed| (target.check)(seed));
    }
}
