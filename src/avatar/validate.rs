//! What an avatar must be before anything is done with it.

use super::{Avatar, AvatarError};
use crate::network::{Compact, Mlp, Region, SurfaceFunction};
use glam::Vec3A;
use std::collections::HashSet;

/// Joints of the skeleton.
const JOINT_COUNT: usize = 24;
/// Levels multiply the triangles by 4; a fifth would make a small body's mesh a gigabyte.
const LARGEST_LEVEL_COUNT: u32 = 4;
/// Of the finest level: forty times the open body's, and about two gigabytes to animate.
const LARGEST_VERTEX_COUNT: usize = 1 << 22;
/// 2²⁴ π x has no precision left in f32.
const LARGEST_FREQUENCY_COUNT: u32 = 24;

impl Avatar {
    /// Checks that all parts are there, fit each other and are finite. `file` is a name for messages.
    ///
    /// The exact length of `factor.values` follows from topology and permutation; [`crate::animate::Animator::new`] checks it.
    pub fn validate(&self, file: &str) -> Result<(), AvatarError> {
        Check { file, avatar: self }.all()
    }
}

struct Check<'a> {
    file: &'a str,
    avatar: &'a Avatar,
}

type Checked = Result<(), AvatarError>;

impl Check<'_> {
    fn all(&self) -> Checked {
        self.skeleton()?;
        self.vertices()?;
        let vertex_counts = self.topology()?;
        self.appearance()?;
        let levels = [
            ("deformation", &self.avatar.deformation, 0),
            ("laplacian", &self.avatar.laplacian, vertex_counts.len() - 1),
        ];
        for (field, function, finest_level) in levels {
            self.require(
                function.level() <= finest_level,
                &format!("{field}.level"),
                format!("at most {finest_level}"),
                function.level(),
            )?;
            match function {
                SurfaceFunction::Mlp(mlp) => self.mlp(mlp, field)?,
                SurfaceFunction::Compact(compact) => self.compact(compact, field, vertex_counts[function.level()])?,
            }
        }
        self.solver(vertex_counts[vertex_counts.len() - 1])
    }

    fn require(&self, holds: bool, field: &str, expected: impl ToString, found: impl ToString) -> Checked {
        if holds { Ok(()) } else { Err(AvatarError::new(self.file, field, expected, found)) }
    }

    fn count(&self, field: &str, expected: usize, found: usize) -> Checked {
        self.require(found == expected, field, format!("{expected} entries"), found)
    }

    fn finite<'n>(&self, field: &str, numbers: impl IntoIterator<Item = &'n f32>) -> Checked {
        match numbers.into_iter().enumerate().find(|(_, number)| !number.is_finite()) {
            Some((i, number)) => self.require(false, &format!("{field}[{i}]"), "a finite number", number),
            None => Ok(()),
        }
    }

    fn finite_points(&self, field: &str, points: &[Vec3A]) -> Checked {
        match points.iter().position(|point| !point.is_finite()) {
            Some(i) => self.require(false, &format!("{field}[{i}]"), "finite numbers", points[i]),
            None => Ok(()),
        }
    }

    fn skeleton(&self) -> Checked {
        let rig = &self.avatar.rig;
        self.count("joints", JOINT_COUNT, rig.rest_joints.len())?;
        self.count("joint parents", JOINT_COUNT, rig.parents.len())?;
        self.count("joint names", JOINT_COUNT, rig.joint_names.len())?;
        self.finite_points("joints", &rig.rest_joints)?;
        for (joint, &parent) in rig.parents.iter().enumerate() {
            let holds = if joint == 0 { parent.is_none() } else { parent.is_some_and(|parent| parent < joint) };
            let expected = if joint == 0 { "none".into() } else { format!("a joint before {joint}") };
            self.require(holds, &format!("parent of joint {joint}"), expected, format!("{parent:?}"))?;
        }
        Ok(())
    }

    fn vertices(&self) -> Checked {
        let rig = &self.avatar.rig;
        let count = rig.rest.len();
        self.require(count > 0, "rest", "at least one vertex", count)?;
        self.count("canonical", count, self.avatar.canonical.len())?;
        self.count("skin joints", count, rig.skin.joints.len())?;
        self.count("skin weights", count, rig.skin.weights.len())?;
        self.finite_points("rest", &rig.rest)?;
        self.finite_points("canonical", &self.avatar.canonical)?;
        for (vertex, (joints, weights)) in rig.skin.joints.iter().zip(&rig.skin.weights).enumerate() {
            let in_range = joints.iter().all(|&joint| (joint as usize) < JOINT_COUNT);
            let sum: f32 = weights.iter().sum();
            let fair = weights.iter().all(|&weight| weight >= 0.0) && (sum - 1.0).abs() < 1e-3;
            let repeated =
                (0..4).any(|i| (0..i).any(|j| joints[i] == joints[j] && weights[i] > 0.0 && weights[j] > 0.0));
            // A message for each of all the vertices would take longer than reading them.
            if in_range && fair && !repeated {
                continue;
            }
            let field = format!("skin of vertex {vertex}");
            self.require(in_range, &field, format!("joints below {JOINT_COUNT}"), format!("{joints:?}"))?;
            self.require(fair, &field, "weights that sum to 1", format!("{weights:?}"))?;
            self.require(false, &field, "each joint once", format!("{joints:?}"))?;
        }
        if let Some(directions) = &rig.pose_directions {
            self.count("pose directions", 9 * (JOINT_COUNT - 1), directions.len())?;
            for direction in directions {
                self.count("pose direction", count, direction.len())?;
                self.finite_points("pose direction", direction)?;
            }
        }
        Ok(())
    }

    /// An oriented manifold, with or without boundary, that every vertex belongs to. Gives the vertices of each level.
    fn topology(&self) -> Result<Vec<usize>, AvatarError> {
        let triangles = &self.avatar.triangles;
        let count = self.avatar.rig.rest.len();
        // Grows with what is sound: a list of the same triangle takes nothing.
        let mut half_edges = HashSet::new();
        let mut used = vec![false; count];
        for (t, &[a, b, c]) in triangles.iter().enumerate() {
            let fault = |expected: String| {
                AvatarError::new(self.file, &format!("triangle {t}"), expected, format!("{:?}", [a, b, c]))
            };
            let proper = a != b && b != c && c != a && [a, b, c].iter().all(|&v| (v as usize) < count);
            if !proper {
                return Err(fault(format!("three vertices below {count}")));
            }
            for edge in [(a, b), (b, c), (c, a)] {
                used[edge.0 as usize] = true;
                if !half_edges.insert(edge) {
                    return Err(fault("edges that no other triangle runs through the same way".into()));
                }
            }
        }
        if let Some(vertex) = used.iter().position(|used| !used) {
            self.require(false, "triangles", format!("one at vertex {vertex}"), "none")?;
        }
        let level_count = self.avatar.level_count;
        self.require(
            level_count <= LARGEST_LEVEL_COUNT,
            "levelCount",
            format!("at most {LARGEST_LEVEL_COUNT}"),
            level_count,
        )?;
        let mut edges = half_edges.iter().filter(|(a, b)| a < b || !half_edges.contains(&(*b, *a))).count();
        let mut faces = triangles.len();
        let mut vertex_counts = vec![count];
        for level in 0..level_count as usize {
            vertex_counts.push(vertex_counts[level] + edges);
            edges = 2 * edges + 3 * faces;
            faces *= 4;
        }
        let finest = vertex_counts[vertex_counts.len() - 1];
        let limit = format!("at most {LARGEST_VERTEX_COUNT} vertices on the finest level");
        self.require(finest <= LARGEST_VERTEX_COUNT, "levelCount", limit, finest)?;
        Ok(vertex_counts)
    }

    fn appearance(&self) -> Checked {
        let appearance = &self.avatar.appearance;
        let count = appearance.drawn_vertices.len();
        self.count("drawn triangles", self.avatar.triangles.len(), appearance.drawn_triangles.len())?;
        for (t, (drawn, &triangle)) in appearance.drawn_triangles.iter().zip(&self.avatar.triangles).enumerate() {
            let vertices = drawn.map(|v| appearance.drawn_vertices.get(v as usize).copied());
            if vertices != triangle.map(Some) {
                let [expected, found] = [format!("{triangle:?}"), format!("{vertices:?}")];
                self.require(false, &format!("drawn triangle {t}"), expected, found)?;
            }
        }
        if let Some(&vertex) = appearance.drawn_vertices.iter().find(|&&v| v as usize >= self.avatar.rig.rest.len()) {
            self.require(false, "drawn vertices", "vertices of the body", vertex)?;
        }
        if let Some(texture) = &appearance.texture {
            self.count("texture coordinates", count, appearance.texture_coordinates.len())?;
            let signature: &[u8] = match texture.mime.as_str() {
                "image/png" => b"\x89PNG\r\n\x1a\n",
                "image/jpeg" => b"\xff\xd8\xff",
                other => return self.require(false, "texture", "image/png or image/jpeg", other),
            };
            self.require(texture.bytes.starts_with(signature), "texture", &texture.mime, "another kind of file")?;
        }
        if !appearance.texture_coordinates.is_empty() {
            self.count("texture coordinates", count, appearance.texture_coordinates.len())?;
            self.finite("texture coordinates", appearance.texture_coordinates.iter().flatten())?;
        }
        if !appearance.vertex_colours.is_empty() {
            self.count("vertex colours", count, appearance.vertex_colours.len())?;
        }
        Ok(())
    }

    fn mlp(&self, mlp: &Mlp, field: &str) -> Checked {
        let frequencies = mlp.encoding.frequency_count;
        let limit = format!("at most {LARGEST_FREQUENCY_COUNT}");
        self.require(frequencies <= LARGEST_FREQUENCY_COUNT, &format!("{field}.frequencyCount"), limit, frequencies)?;
        self.finite(&format!("{field}.outputScale"), [&mlp.output_scale])?;
        self.require(!mlp.layers.is_empty(), &format!("{field}.layers"), "at least one", 0)?;
        let mut inputs = mlp.encoding.length() + 3 * JOINT_COUNT;
        for (i, layer) in mlp.layers.iter().enumerate() {
            let outputs = layer.bias.len();
            let field = format!("{field}.layers[{i}]");
            self.require(outputs > 0, &field, "at least one output", outputs)?;
            self.count(&format!("{field}.weight"), inputs * outputs, layer.weight.len())?;
            self.finite(&format!("{field}.weight"), &layer.weight)?;
            self.finite(&format!("{field}.bias"), &layer.bias)?;
            inputs = outputs;
        }
        self.require(inputs == 3, &format!("{field}.layers"), "three outputs of the last", inputs)
    }

    fn compact(&self, compact: &Compact, field: &str, vertex_count: usize) -> Checked {
        let name = |part: &str| format!("{field}.{part}");
        let rows = compact.row_vertices.len();
        let centres = compact.centre_count as usize;
        self.count(&name("centres"), centres * JOINT_COUNT * 6, compact.centres.len())?;
        self.count(&name("mean"), rows * 3, compact.mean.len())?;
        self.finite(&name("centres"), &compact.centres)?;
        self.finite(&name("mean"), &compact.mean)?;
        self.finite(&name("basisStep"), &compact.basis_step)?;
        if let Some(vertex) = compact.row_vertices.iter().find(|&&vertex| vertex as usize >= vertex_count) {
            self.require(false, &name("rowVertices"), format!("vertices below {vertex_count}"), vertex)?;
        }
        let (mut start, mut steps, mut entries) = (0, 0, 0);
        for (r, region) in compact.regions.iter().enumerate() {
            let field = format!("{field}.regions[{r}]");
            self.region(region, &field, centres)?;
            let (first, end) = region.rows;
            let follows = first == start && end >= start && end as usize <= rows;
            self.require(
                follows,
                &format!("{field}.rows"),
                format!("from {start}, up to {rows}"),
                format!("{:?}", region.rows),
            )?;
            start = end;
            steps += region.basis_count as usize;
            entries += 3 * region.basis_count as usize * (end - first) as usize;
        }
        self.require(start as usize == rows, &name("regions"), format!("rows up to {rows}"), start)?;
        self.count(&name("basisStep"), steps, compact.basis_step.len())?;
        self.count(&name("basis"), entries, compact.basis.len())
    }

    fn region(&self, region: &Region, field: &str, centres: usize) -> Checked {
        let mask = region.mask.0;
        let proper = mask & 1 == 0 && mask >> JOINT_COUNT == 0;
        self.require(proper, &format!("{field}.mask"), "joints 1 to 23", mask)?;
        let length = region.kernel_length;
        self.require(length.is_finite() && length > 0.0, &format!("{field}.kernelLength"), "above 0", length)?;
        let place = |part: &str| format!("{field}.{part}");
        let field = place("coefficientFromKernel");
        self.count(&field, region.basis_count as usize * centres, region.coefficient_from_kernel.len())?;
        self.finite(&field, &region.coefficient_from_kernel)?;
        let field = place("recalled");
        let recalled = region.recalled_count();
        self.require(recalled <= centres, &field, format!("at most {centres} poses"), recalled)?;
        self.count(&field, region.basis_count as usize * recalled, region.recalled.len())?;
        self.finite(&field, &region.recalled)?;
        let Some([nothing, full]) = region.fade else { return Ok(()) };
        let ascending = 0.0 <= nothing && nothing < full && full <= 1.0 && recalled > 0;
        let expected = "two ascending numbers from 0 to 1 in a region that recalls";
        self.require(ascending, &place("fade"), expected, format!("[{nothing}, {full}], {recalled} recalled"))
    }

    fn solver(&self, finest_count: usize) -> Checked {
        let Avatar { anchors, anchor_weight, factor, rig, .. } = self.avatar;
        self.require(!anchors.is_empty(), "anchors", "at least one", 0)?;
        if let Some(pair) = anchors.windows(2).find(|pair| pair[0] >= pair[1]) {
            self.require(false, "anchors", "ascending vertices", format!("{} before {}", pair[0], pair[1]))?;
        }
        let last = anchors[anchors.len() - 1];
        self.require((last as usize) < finest_count, "anchors", format!("vertices below {finest_count}"), last)?;
        let positive = |number: f32| number.is_finite() && number > 0.0;
        self.require(positive(*anchor_weight), "anchorWeight", "above 0", anchor_weight)?;

        let count = rig.rest.len();
        self.count("factor.permutation", count, factor.permutation.len())?;
        let mut seen = vec![false; count];
        for &vertex in &factor.permutation {
            let new = seen.get_mut(vertex as usize).is_some_and(|seen| !std::mem::replace(seen, true));
            self.require(new, "factor.permutation", "each vertex once", vertex)?;
        }
        self.count("factor.diagonal", count, factor.diagonal.len())?;
        if let Some(number) = factor.diagonal.iter().find(|&&number| !positive(number)) {
            self.require(false, "factor.diagonal", "numbers above 0", number)?;
        }
        let largest = count * (count - 1) / 2;
        self.require(
            factor.values.len() <= largest,
            "factor.values",
            format!("at most {largest}"),
            factor.values.len(),
        )?;
        if let Some(number) = factor.values.iter().find(|number| !number.is_finite()) {
            self.require(false, "factor.values", "finite numbers", number)?;
        }
        Ok(())
    }
}
