use super::glb::Glb;
use super::*;
use crate::fixture::{compact_avatar, plain_avatar};
use serde_json::{Value, json};

fn both() -> [Avatar; 2] {
    [compact_avatar(), plain_avatar()]
}

/// `file` with its JSON changed.
fn with_json(file: &[u8], change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let glb = Glb::parse(file, "test").unwrap();
    let mut json: Value = serde_json::from_slice(glb.json).unwrap();
    change(&mut json);
    Glb::assemble(serde_json::to_vec(&json).unwrap(), glb.binary.to_vec())
}

/// The error of reading `file` with its JSON changed.
fn error_of(file: &[u8], change: impl FnOnce(&mut Value)) -> AvatarError {
    Avatar::read(&with_json(file, change), "test.glb").expect_err("the file is wrong")
}

/// `file` with its table or accessor bytes changed; `view` points to the buffer view's number in the JSON.
fn with_bytes(file: &[u8], view: impl Fn(&Value) -> Value, change: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let glb = Glb::parse(file, "test").unwrap();
    let json: Value = serde_json::from_slice(glb.json).unwrap();
    let view = &json["bufferViews"][view(&json).as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap_or(0) as usize;
    let length = view["byteLength"].as_u64().unwrap() as usize;
    let mut binary = glb.binary.to_vec();
    change(&mut binary[start..start + length]);
    Glb::assemble(glb.json.to_vec(), binary)
}

/// `file` with the numbers of one of the extension's tables changed; `path` is its JSON pointer in the extension.
fn with_table(file: &[u8], path: &str, change: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let glb = Glb::parse(file, "test").unwrap();
    let mut json: Value = serde_json::from_slice(glb.json).unwrap();
    let table = crease(&json).pointer(path).unwrap();
    let view = &json["bufferViews"][table["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap_or(0) as usize;
    let mut bytes = glb.binary[start..start + view["byteLength"].as_u64().unwrap() as usize].to_vec();
    if table["packed"] == json!(true) {
        let size = if table["type"] == "i8" {
            1
        } else if table["type"] == "f32" {
            4
        } else {
            2
        };
        let count: u64 = table["shape"].as_array().unwrap().iter().map(|length| length.as_u64().unwrap()).product();
        bytes = deflate::unpack(&bytes, count as usize * size, size).unwrap();
    }
    change(&mut bytes);
    // A view of its own, as it is.
    let mut binary = glb.binary.to_vec();
    let views = json["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len()}));
    let view = views.len() - 1;
    binary.extend(bytes);
    binary.resize(binary.len().next_multiple_of(4), 0);
    json["buffers"][0]["byteLength"] = json!(binary.len());
    let table = json["extensions"]["CREASE_avatar"].pointer_mut(path).unwrap();
    table["bufferView"] = json!(view);
    table["packed"] = json!(false);
    Glb::assemble(serde_json::to_vec(&json).unwrap(), binary)
}

fn crease(json: &Value) -> &Value {
    &json["extensions"]["CREASE_avatar"]
}

#[test]
fn reading_gives_back_the_quantised_avatar_and_writing_that_the_same_bytes() {
    for avatar in both() {
        let file = avatar.write();
        let read = Avatar::read(&file, "test.glb").unwrap();
        assert!(read == avatar.quantised(), "{}", avatar.name);
        assert!(read.write() == file, "{}", avatar.name);
    }
}

#[test]
fn provenance_and_pose_directions_survive() {
    let mut avatar = compact_avatar();
    avatar.provenance.insert("nc".into(), json!(0.1 + 0.2));
    avatar.provenance.insert("nested".into(), json!({"seed": 7, "frames": [1, 2], "licence": "ö"}));
    let count = avatar.rig.rest.len();
    avatar.rig.pose_directions = Some((0..207).map(|n| vec![Vec3A::splat(1e-3 * n as f32); count]).collect());
    let read = Avatar::read(&avatar.write(), "test.glb").unwrap();
    assert_eq!(read.provenance, avatar.provenance);
    assert_eq!(read.rig.pose_directions, avatar.quantised().rig.pose_directions);
    let found = read.rig.pose_directions.unwrap()[206][0].x;
    assert!((found - 0.206).abs() < 0.206 / 2048.0, "half precision: {found}");
}

#[test]
fn fading_survives_and_needs_what_is_recalled() {
    let mut avatar = compact_avatar();
    let SurfaceFunction::Compact(tables) = &mut avatar.laplacian else { panic!("compact") };
    let recalling = tables.regions.iter().position(|region| region.recalled_count() > 0).unwrap();
    tables.regions[recalling].fade = Some([0.02, 0.3]);
    let read = Avatar::read(&avatar.write(), "test.glb").unwrap();
    let SurfaceFunction::Compact(tables) = &read.laplacian else { panic!("compact") };
    for (index, region) in tables.regions.iter().enumerate() {
        assert_eq!(region.fade, (index == recalling).then_some([0.02, 0.3]));
    }
    let field = format!("laplacian.regions[{recalling}].fade");
    for wrong in [[0.3, 0.3], [-0.1, 0.3], [0.3, 1.5]] {
        let error = error_of(&avatar.write(), |json| {
            json["extensions"]["CREASE_avatar"]["laplacian"]["regions"][recalling]["fade"] = json!(wrong);
        });
        assert_eq!(error.field, field);
    }
    let SurfaceFunction::Compact(tables) = &mut avatar.laplacian else { panic!("compact") };
    tables.regions[recalling].recalled.clear();
    assert_eq!(Avatar::read(&avatar.write(), "test.glb").unwrap_err().field, field);
}

#[test]
fn an_unknown_major_version_is_named_and_a_minor_one_is_read() {
    let file = compact_avatar().write();
    let error = error_of(&file, |json| {
        // Another version may hold anything.
        json["extensions"]["CREASE_avatar"] = json!({"version": {"major": 1, "minor": 0}, "old": true});
    });
    assert_eq!(error.field, "CREASE_avatar.version.major");
    assert_eq!(error.found, "1");
    assert!(error.expected.starts_with("2,"));
    let minor = with_json(&file, |json| {
        json["extensions"]["CREASE_avatar"]["version"]["minor"] = json!(9);
        json["extensions"]["CREASE_avatar"]["somethingNew"] = json!([1, 2]);
    });
    assert!(Avatar::read(&minor, "test.glb").is_ok());
}

#[test]
fn other_files_are_told_by_their_header() {
    let file = compact_avatar().write();
    for (at, byte, field) in [(0, b'G', "header.magic"), (4, 3, "header.version"), (8, 0, "header.length")] {
        let mut wrong = file.clone();
        wrong[at] = if wrong[at] == byte { byte + 1 } else { byte };
        assert_eq!(Avatar::read(&wrong, "test.glb").unwrap_err().field, field);
    }
    let error = Avatar::read(b"{}", "test.glb").unwrap_err();
    assert_eq!(error.to_string(), "test.glb: header: expected 12 bytes, found 2 bytes");
    let plain = with_json(&file, |json| {
        json.as_object_mut().unwrap().remove("extensions");
    });
    let error = Avatar::read(&plain, "test.glb").unwrap_err();
    assert_eq!(error.to_string(), "test.glb: extensions: expected an object, found nothing");
}

#[test]
fn json_that_takes_too_much_memory_is_refused() {
    let file = compact_avatar().write();
    let bloated = with_json(&file, |json| json["extras"] = json!(vec![0; 1 << 21]));
    let error = Avatar::read(&bloated, "test.glb").unwrap_err();
    assert!(error.field == "JSON chunk" && error.expected.contains("bytes in memory"), "{error}");
    let more = with_json(&file, |json| json["extras"] = json!(vec![0; 1 << 10]));
    assert!(Avatar::read(&more, "test.glb").is_ok());
}

#[test]
fn a_file_cut_short_anywhere_is_an_error() {
    for avatar in both() {
        let file = avatar.write();
        for length in 0..file.len() {
            assert!(Avatar::read(&file[..length], "test.glb").is_err(), "cut to {length} bytes");
        }
        // The same with a header that agrees with the length, and with a shorter binary chunk.
        for length in (28..file.len()).step_by(file.len() / 200) {
            let mut cut = file[..length].to_vec();
            cut[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            assert!(Avatar::read(&cut, "test.glb").is_err(), "cut to {length} bytes");
            let glb = Glb::parse(&file, "test").unwrap();
            let shorter = Glb::assemble(glb.json.to_vec(), glb.binary[..glb.binary.len().min(length) - 4].to_vec());
            assert!(Avatar::read(&shorter, "test.glb").is_err(), "binary cut to {length} bytes");
        }
    }
}

#[test]
fn a_flipped_bit_gives_an_error_or_a_valid_avatar() {
    for avatar in both() {
        let mut file = avatar.write();
        let json_end = 20 + Glb::parse(&file, "test").unwrap().json.len();
        let (mut errors, mut valid) = (0, 0);
        // Much of the JSON, some of the numbers.
        let places = (0..json_end).step_by(5).chain((json_end..file.len()).step_by(301));
        for (i, at) in places.enumerate() {
            let bit = 1 << (i * 5 % 8);
            file[at] ^= bit;
            match Avatar::read(&file, "test.glb") {
                Ok(read) => {
                    valid += 1;
                    read.validate("read").unwrap();
                }
                Err(_) => errors += 1,
            }
            file[at] ^= bit;
        }
        assert!(errors > 100 && valid > 100, "{errors} errors, {valid} valid");
    }
}

#[test]
fn errors_name_field_expected_and_found() {
    type Change = fn(&mut Value);
    let changes: &[(&str, Change)] = &[
        ("CREASE_avatar.units", |e| e["units"]["length"] = json!("inch")),
        ("CREASE_avatar.association", |e| e["association"][1] = json!(1)),
        ("mesh", |e| e["mesh"] = json!(1)),
        ("skin", |e| e["skin"] = json!(7)),
        ("rest.type", |e| e["rest"]["type"] = json!("u16")),
        ("rest.shape", |e| e["rest"]["shape"] = json!([1, 2, 3])),
        ("rest.bufferView", |e| e["rest"]["shape"][0] = json!(1u64 << 40)),
        ("rest.bufferView", |e| e["rest"]["bufferView"] = json!(1_000_000)),
        ("rest.bufferView", |e| e["rest"]["packed"] = json!(e["rest"]["packed"] != json!(true))),
        ("anchors.bufferView", |e| e["anchors"]["packed"] = json!(e["anchors"]["packed"] != json!(true))),
        ("canonical.shape", |e| e["canonical"]["shape"][0] = json!(9)),
        ("levelCount", |e| e["levelCount"] = json!(30)),
        ("deformation.level", |e| e["deformation"]["level"] = json!(1)),
        ("laplacian.level", |e| e["laplacian"]["level"] = json!(3)),
        ("laplacian.regions[0].mask", |e| e["laplacian"]["regions"][0]["mask"] = json!(1)),
        ("laplacian.regions[1].rows", |e| e["laplacian"]["regions"][1]["rows"][0] = json!(0)),
        ("laplacian.regions[0].kernelLength", |e| e["laplacian"]["regions"][0]["kernelLength"] = json!(0.0)),
        ("laplacian.rowVertices.shape", |e| e["laplacian"]["rowVertices"]["shape"] = json!([])),
        ("anchorWeight", |e| e["anchorWeight"] = json!(-1.0)),
        ("factor.permutation.shape", |e| e["factor"]["permutation"]["shape"][0] = json!(3)),
        ("factor.values.type", |e| e["factor"]["values"]["type"] = json!("f32")),
        ("CREASE_avatar.scheme", |e| e["scheme"] = json!("cubic")),
        ("CREASE_avatar.laplacian.kind", |e| e["laplacian"]["kind"] = json!("table")),
        ("CREASE_avatar.laplacian.regions[1].rows", |e| e["laplacian"]["regions"][1]["rows"] = json!([1])),
        ("CREASE_avatar.rest.type", |e| e["rest"]["type"] = json!("f64")),
        ("CREASE_avatar.rest.shape[1]", |e| e["rest"]["shape"][1] = json!(-3)),
        ("CREASE_avatar.anchors", |e| e["anchors"] = json!(null)),
        ("CREASE_avatar.anchorWeight", |e| e["anchorWeight"] = json!(1e300)),
        ("CREASE_avatar.provenance", |e| e["provenance"] = json!("none")),
    ];
    let file = compact_avatar().write();
    for (field, change) in changes {
        let error = error_of(&file, |json| change(&mut json["extensions"]["CREASE_avatar"]));
        assert_eq!(error.field, *field, "{error}");
        assert_eq!(error.file, "test.glb");
        assert_ne!(error.expected, error.found);
    }
}

#[test]
fn errors_of_the_standard_part_are_named() {
    type Change = fn(&mut Value);
    let changes: &[(&str, Change)] = &[
        ("skin.joints", |j| j["skins"][0]["joints"][0] = json!(99)),
        ("inverseBindMatrices.count", |j| {
            j["skins"][0]["joints"].as_array_mut().unwrap().pop();
        }),
        ("parent of joint 1", |j| j["nodes"][0]["children"] = json!([2, 3])),
        ("rest.bufferView", |j| {
            j["bufferViews"].as_array_mut().unwrap().iter_mut().for_each(|v| v["buffer"] = json!(1))
        }),
        ("JOINTS_0", |j| j["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(0)),
        ("indices", |j| {
            let index = j["meshes"][0]["primitives"][0]["indices"].as_u64().unwrap() as usize;
            j["accessors"][index]["byteOffset"] = json!(u64::MAX);
        }),
        ("indices.count", |j| {
            let index = j["meshes"][0]["primitives"][0]["indices"].as_u64().unwrap() as usize;
            j["accessors"][index]["count"] = json!(4);
        }),
        ("POSITION", |j| {
            let index = j["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap() as usize;
            let view = j["accessors"][index]["bufferView"].as_u64().unwrap() as usize;
            j["bufferViews"][view]["byteStride"] = json!(16);
        }),
    ];
    let file = compact_avatar().write();
    for (field, change) in changes {
        let error = error_of(&file, |json| {
            if *field == "rest.bufferView" {
                // Two buffers, so that the index itself is in range.
                json["buffers"].as_array_mut().unwrap().push(json!({"byteLength": 4}));
            }
            change(json);
        });
        let expected = if *field == "rest.bufferView" { "rest.bufferView" } else { field };
        assert_eq!(error.field, expected, "{error}");
    }
}

#[test]
fn numbers_out_of_range_are_named() {
    let file = compact_avatar().write();
    let read = |file: Vec<u8>| Avatar::read(&file, "test.glb").expect_err("the file is wrong").field;
    let field = |path: &str, change: fn(&mut [u8])| read(with_table(&file, path, change));
    assert_eq!(field("/rest", |b| b[..4].copy_from_slice(&f32::NAN.to_le_bytes())), "rest[0]");
    assert_eq!(field("/anchors", |b| b[..4].copy_from_slice(&[9, 0, 3, 0])), "anchors");
    assert_eq!(field("/drawnVertices", |b| b[..2].fill(0xff)), "drawnVertices");
    assert_eq!(field("/factor/permutation", |b| b.copy_within(0..2, 2)), "factor.permutation");
    assert_eq!(field("/factor/diagonal", |b| b[..4].fill(0)), "factor.diagonal");
    assert_eq!(field("/laplacian/rowVertices", |b| b[..2].fill(0xff)), "laplacian.rowVertices");
    assert!(Avatar::read(&with_table(&file, "/rest", |_| ()), "test.glb").is_ok(), "tables may lie as they are");
    let view = |j: &Value, accessor: &Value| j["accessors"][accessor.as_u64().unwrap() as usize]["bufferView"].clone();
    let json: Value = serde_json::from_slice(Glb::parse(&file, "test").unwrap().json).unwrap();
    let weights = view(&json, &json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"]);
    assert_eq!(read(with_bytes(&file, |_| weights.clone(), |b| b[..8].fill(1))), "WEIGHTS_0");
    let indices = view(&json, &json["meshes"][0]["primitives"][0]["indices"]);
    assert_eq!(read(with_bytes(&file, |_| indices.clone(), |b| b[..2].fill(0xff))), "indices");
    assert_eq!(read(with_bytes(&file, |_| indices.clone(), |b| b.copy_within(6..12, 0))), "triangle 1");
}

#[test]
fn validate_finds_what_no_file_check_can() {
    let broken = |change: fn(&mut Avatar)| {
        let mut avatar = plain_avatar();
        change(&mut avatar);
        avatar.validate("test").expect_err("the avatar is wrong").field
    };
    assert_eq!(broken(|a| a.rig.parents[5] = Some(9)), "parent of joint 5");
    assert_eq!(broken(|a| a.rig.skin.weights[3] = [0.5, 0.0, 0.0, 0.0]), "skin of vertex 3");
    assert_eq!(broken(|a| a.triangles.swap(0, 5)), "drawn triangle 0");
    assert_eq!(broken(|a| a.appearance.texture.as_mut().unwrap().mime = "image/gif".into()), "texture");
    assert_eq!(broken(|a| a.appearance.texture.as_mut().unwrap().mime = "image/jpeg".into()), "texture");
    assert_eq!(broken(|a| a.anchors.reverse()), "anchors");
    assert_eq!(broken(|a| a.rig.rest.push(Vec3A::ZERO)), "canonical");
    assert_eq!(
        broken(|a| {
            let SurfaceFunction::Mlp(mlp) = &mut a.laplacian else { unreachable!() };
            mlp.layers[1].weight.pop();
        }),
        "laplacian.layers[1].weight"
    );
}

#[test]
fn other_gltf_readers_see_a_skinned_figure() {
    for avatar in both() {
        let file = avatar.write();
        let (document, buffers, images) = gltf::import_slice(&file).unwrap();
        let skin = document.skins().next().unwrap();
        let names: Vec<_> = skin.joints().map(|joint| joint.name().unwrap().to_owned()).collect();
        assert_eq!(names, avatar.rig.joint_names);
        let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
        let drawn = &avatar.appearance;
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, drawn.drawn_triangles.concat());
        let positions: Vec<_> = reader.read_positions().unwrap().collect();
        assert_eq!(positions.len(), drawn.drawn_vertices.len());
        for (position, &vertex) in positions.iter().zip(&drawn.drawn_vertices) {
            let distance = Vec3A::from_array(*position).distance(avatar.rig.rest[vertex as usize]);
            assert!(distance < 0.06, "{distance} m from the body");
        }
        for weights in reader.read_weights(0).unwrap().into_u16() {
            assert_eq!(weights.iter().map(|&weight| u32::from(weight)).sum::<u32>(), 65535);
        }
        for (matrix, joint) in reader_matrices(&skin, &buffers).iter().zip(&avatar.rig.rest_joints) {
            assert_eq!(Vec3A::from_slice(&matrix[3][..3]), -*joint);
        }
        match &drawn.texture {
            Some(_) => {
                assert_eq!((images[0].width, images[0].height), (2, 2));
                let coordinates: Vec<_> = reader.read_tex_coords(0).unwrap().into_f32().collect();
                assert_eq!(coordinates, drawn.texture_coordinates);
            }
            None => {
                let colours: Vec<_> = reader.read_colors(0).unwrap().into_rgb_u8().collect();
                assert_eq!(colours, drawn.vertex_colours);
            }
        }
    }
}

fn reader_matrices(skin: &gltf::Skin, buffers: &[gltf::buffer::Data]) -> Vec<[[f32; 4]; 4]> {
    let reader = skin.reader(|buffer| Some(&buffers[buffer.index()]));
    reader.read_inverse_bind_matrices().unwrap().collect()
}
