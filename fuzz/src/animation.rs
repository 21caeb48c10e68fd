//! The player and the animator: whatever valid avatar, pose and sequence of calls, finite meshes and a clock within its motion.

use arbitrary::{Arbitrary, Result, Unstructured};
use crease::animate::{Animator, Options, Stage};
use crease::avatar::{Appearance, Avatar, Form};
use crease::body::{Pose, Rig, Skin};
use crease::encoding::PositionalEncoding;
use crease::mesh::{Scheme, Subdivision, Triangle};
use crease::motion::Motion;
use crease::network::{Compact, Layer, Mlp, Region, SurfaceFunction};
use crease::player::{Player, QUALITY_LEVELS};
use crease::pose_feature::PoseMask;
use crease::solver::{CoarseFactor, Stop};
use glam::{Quat, Vec3, Vec3A};
use std::sync::Arc;

const JOINT_COUNT: usize = 24;

/// Small closed surfaces, and one with a border.
const SHAPES: [(&[[f32; 3]], &[Triangle]); 3] = [
    (
        &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    ),
    (
        &[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]],
        &[[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
    ),
    (&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2], [0, 2, 3]]),
];

/// Numbers of `bytes`, and zeros once they are used up.
struct Numbers<'a, 'b>(&'a mut Unstructured<'b>);

impl Numbers<'_, '_> {
    fn below(&mut self, count: usize) -> usize {
        self.0.choose_index(count).unwrap_or(0)
    }

    /// −1 ..= 1.
    fn unit(&mut self) -> f32 {
        f32::from(self.0.arbitrary::<i16>().unwrap_or(0)) / 32768.0
    }

    /// As many of them, each `size` at most.
    fn units(&mut self, count: usize, size: f32) -> Vec<f32> {
        (0..count).map(|_| size * self.unit()).collect()
    }

    fn point(&mut self, size: f32) -> Vec3A {
        Vec3A::new(self.unit(), self.unit(), self.unit()) * size
    }

    fn rotation(&mut self) -> Quat {
        let axis_angle = Vec3::from(self.point(7.0));
        Quat::from_scaled_axis(axis_angle)
    }
}

/// A valid avatar of a few vertices, its numbers within a hundred times what training gives.
pub fn small_avatar(source: &mut Unstructured) -> Avatar {
    let mut numbers = Numbers(source);
    let (positions, triangles) = SHAPES[numbers.below(SHAPES.len())];
    let count = positions.len();
    let level_count = 1 + numbers.below(2);
    let subdivision = Subdivision::new(count, triangles, level_count);
    let joint = |numbers: &mut Numbers| numbers.below(JOINT_COUNT) as u8;
    let skin = (0..count).map(|_| {
        let first = joint(&mut numbers);
        let weight = (0.5 + 0.5 * numbers.unit()).clamp(0.0, 1.0);
        ([first, (first + 1) % JOINT_COUNT as u8, 0, 0], [weight, 1.0 - weight, 0.0, 0.0])
    });
    let (joints, weights): (Vec<[u8; 4]>, Vec<[f32; 4]>) = skin.unzip();
    let rest: Vec<Vec3A> = positions.iter().map(|&p| Vec3A::from_array(p) + numbers.point(0.3)).collect();
    let finest_count = subdivision.vertex_count(level_count);
    let mut anchors: Vec<u32> = (0..1 + numbers.below(4)).map(|_| numbers.below(finest_count) as u32).collect();
    anchors.sort_unstable();
    anchors.dedup();
    let anchor_weight = 0.01 + numbers.unit().abs();
    let deformation = function(&mut numbers, 0, count, 1.0);
    let level = numbers.below(level_count + 1);
    let laplacian = function(&mut numbers, level, subdivision.vertex_count(level), 1000.0);
    Avatar {
        name: "small".into(),
        rig: Rig {
            rest_joints: (0..JOINT_COUNT).map(|_| numbers.point(1.0)).collect(),
            parents: (0..JOINT_COUNT).map(|joint| joint.checked_sub(1).map(|last| numbers.below(last + 1))).collect(),
            joint_names: (0..JOINT_COUNT).map(|joint| format!("joint {joint}")).collect(),
            skin: Skin { joints, weights },
            pose_directions: None,
            rest,
        },
        canonical: positions.iter().map(|&p| Vec3A::from_array(p)).collect(),
        triangles: triangles.to_vec(),
        appearance: Appearance {
            drawn_vertices: (0..count as u32).collect(),
            drawn_triangles: triangles.to_vec(),
            texture_coordinates: vec![],
            texture: None,
            vertex_colours: vec![[200, 100, 50]; count],
        },
        scheme: [Scheme::Loop, Scheme::Midpoint][numbers.below(2)],
        level_count: level_count as u32,
        deformation,
        laplacian,
        form: [Form::Absolute, Form::Relative][numbers.below(2)],
        factor: CoarseFactor::new(&subdivision, &anchors, anchor_weight),
        anchors,
        anchor_weight,
        provenance: Default::default(),
    }
}

fn function(numbers: &mut Numbers, level: usize, count: usize, size: f32) -> SurfaceFunction {
    if numbers.below(2) == 0 {
        let encoding = PositionalEncoding { frequency_count: numbers.below(4) as u32 };
        let widths = [encoding.length() + 3 * JOINT_COUNT, 1 + numbers.below(4), 3];
        let layers = widths
            .windows(2)
            .map(|pair| Layer { weight: numbers.units(pair[0] * pair[1], 1.0), bias: numbers.units(pair[1], 1.0) });
        let layers = layers.collect();
        return SurfaceFunction::Mlp(Mlp { level: level as u32, encoding, layers, output_scale: 0.1 * size });
    }
    let centre_count = numbers.below(3);
    let region_count = 1 + numbers.below(2);
    let mut tables = Compact {
        level: level as u32,
        centres: numbers.units(centre_count * JOINT_COUNT * 6, 1.0),
        centre_count: centre_count as u32,
        regions: vec![],
        row_vertices: vec![],
        mean: vec![],
        basis: vec![],
        basis_step: vec![],
    };
    for _ in 0..region_count {
        let first = tables.row_vertices.len() as u32;
        let basis_count = numbers.below(3);
        let rows = numbers.below(count + 1);
        for _ in 0..rows {
            tables.row_vertices.push(numbers.below(count) as u32);
            tables.mean.extend(numbers.units(3, size));
            tables.basis.extend((0..3 * basis_count).map(|_| (127.0 * numbers.unit()) as i8));
        }
        tables.basis_step.extend(numbers.units(basis_count, size / 127.0));
        let recalled = numbers.below(centre_count + 1);
        let nothing = 0.5 * numbers.unit().abs();
        tables.regions.push(Region {
            mask: PoseMask((1 + numbers.below(1 << 16) as u32) << 1 & 0xff_fffe),
            rows: (first, first + rows as u32),
            basis_count: basis_count as u32,
            kernel_length: 0.01 + numbers.unit().abs(),
            coefficient_from_kernel: numbers.units(basis_count * centre_count, 1.0),
            recalled: numbers.units(basis_count * recalled, 1.0),
            fade: (basis_count * recalled > 0 && numbers.below(2) == 0).then_some([nothing, nothing + 0.3]),
        });
    }
    SurfaceFunction::Compact(tables)
}

fn pose(numbers: &mut Numbers) -> Pose {
    Pose { rotations: (0..JOINT_COUNT).map(|_| numbers.rotation()).collect(), translation: numbers.point(10.0).into() }
}

/// No surface of a small avatar reaches farther, metres: δ of a thousand per metre on square metres, twice exaggerated.
const FARTHEST: f32 = 1e6;

fn assert_near(positions: &[Vec3A]) {
    let farthest = positions.iter().map(|position| position.length()).fold(0.0, f32::max);
    let finite = positions.iter().all(|position| position.is_finite());
    assert!(finite && farthest <= FARTHEST, "a vertex is {farthest} m away");
}

pub fn animate(bytes: &[u8]) {
    let mut source = Unstructured::new(bytes);
    let avatar = small_avatar(&mut source);
    avatar.validate("small").expect("the avatar is valid");
    let mut animator = Animator::new(Arc::new(avatar)).expect("and can be animated");
    let mut numbers = Numbers(&mut source);
    for _ in 0..2 {
        let pose = pose(&mut numbers);
        let options = Options {
            stage: [Stage::Detailed, Stage::Base, Stage::Body][numbers.below(3)],
            detail: 2.0 * numbers.unit(),
            liveliness: numbers.unit().abs(),
            stop: [Stop::Tolerance(1e-5), Stop::Iterations(3)][numbers.below(2)],
            warm_start: numbers.below(2) == 1,
            level: numbers.below(5),
            solve_level: numbers.below(5),
        };
        assert_near(animator.animate(&pose, &options));
    }
    // Where nothing is carried over, the pose alone decides.
    let last = pose(&mut numbers);
    let first = animator.animate(&last, &Options::default()).to_vec();
    animator.animate(&Pose::rest(JOINT_COUNT), &Options::default());
    assert_eq!(animator.animate(&last, &Options::default()), first);
}

/// What a page may ask of a player, in any order.
#[derive(Debug, Arbitrary)]
enum Call {
    Advance(f64),
    Play,
    Pause,
    Seek(f64),
    Rate(f64),
    Loop(bool),
    /// Motions of so many poses each, and the crossfade between them.
    Motions([u8; 3], f32, f64),
    /// A motion for another skeleton.
    ForeignMotion(u8),
    ShowExactly(f64),
    /// A pose from elsewhere, or the motions again.
    Live(bool, Option<[f32; 3]>),
    /// Numbers that are no pose.
    ForeignLive(Vec<f32>),
    Smoothing(f64),
    TellLaplacian(bool),
    Stage(u8),
    Detail(f32),
    Quality(Option<u8>),
    CountFrame(f64, f64),
    /// What a lost device or a new canvas asks for.
    PoseAgain,
    /// Posed by whoever poses elsewhere, as on a GPU.
    Step(f64),
    /// Another `src`.
    Replace,
}

pub fn player(bytes: &[u8]) {
    // What cannot be read ends the calls.
    let _ = play(bytes);
}

fn play(bytes: &[u8]) -> Result<()> {
    let mut source = Unstructured::new(bytes);
    let new =
        |source: &mut Unstructured| Player::new(Arc::new(small_avatar(source))).expect("a valid avatar can be played");
    let mut player = new(&mut source);
    for _ in 0..64 {
        if source.is_empty() {
            break;
        }
        match source.arbitrary::<Call>()? {
            Call::Advance(seconds) => {
                let animator = player.animator().expect("the detail is prepared");
                let (count, finest) = (player.vertex_count(), animator.subdivision().level_count());
                // What is not finite is an error, which a page shows; what is returned may be drawn.
                if let Ok(Some(posed)) = player.advance(seconds, &mut |_| ()) {
                    assert!(posed.positions.iter().all(|position| position.is_finite()));
                    assert!(posed.positions.len() == posed.normals.len() && posed.positions.len() <= count);
                    assert!(posed.coarser <= finest);
                }
            }
            Call::Play => player.clock.play(),
            Call::Pause => player.clock.pause(),
            Call::Seek(seconds) => player.seek(seconds),
            Call::ShowExactly(seconds) => player.show_exactly(seconds),
            Call::Rate(rate) => player.clock.set_rate(rate),
            Call::Loop(looping) => player.clock.set_looping(looping),
            Call::Motions(counts, rate, crossfade) => {
                let mut numbers = Numbers(&mut source);
                let frames_per_second = if rate.is_finite() { rate.abs().clamp(0.1, 1000.0) } else { 60.0 };
                let mut motion = |count: u8| {
                    let poses = (0..count % 6).map(|_| pose(&mut numbers)).collect();
                    Motion { poses, frames_per_second, notes: Vec::new() }
                };
                let motions = counts.into_iter().filter(|count| count % 6 > 0).map(&mut motion).collect();
                player.set_crossfade(crossfade);
                player.set_motions(motions).expect("the motions fit");
            }
            Call::Live(false, _) => player.set_live_pose(None, None).expect("the motions fit"),
            Call::Live(true, translation) => {
                let rotations = Numbers(&mut source).units(3 * JOINT_COUNT, 7.0);
                let translation = translation.map(Vec3::from_array).filter(|translation| translation.length() < 1e4);
                player.set_live_pose(Some(&rotations), translation).expect("the pose fits");
            }
            Call::ForeignLive(rotations) => {
                let fits = rotations.len() == 3 * JOINT_COUNT;
                assert!(fits || player.set_live_pose(Some(&rotations), None).is_err());
            }
            Call::Smoothing(seconds) => player.set_smoothing(seconds),
            Call::TellLaplacian(tells) => player.tells_laplacian = tells,
            Call::ForeignMotion(joints) => {
                let poses = vec![Pose::rest(usize::from(joints))];
                let motion = Motion { poses, frames_per_second: 30.0, notes: Vec::new() };
                assert_eq!(player.set_motions(vec![motion]).is_ok(), usize::from(joints) == JOINT_COUNT);
            }
            Call::Stage(stage) => {
                player.options.stage = [Stage::Body, Stage::Base, Stage::Detailed][usize::from(stage) % 3]
            }
            Call::Detail(detail) => player.options.detail = detail,
            Call::Quality(level) => player.set_quality(level.map(usize::from)),
            Call::CountFrame(interval, work) => player.count_frame(interval, work),
            Call::PoseAgain => player.pose_again(),
            Call::Step(seconds) => {
                player.step(seconds);
            }
            Call::Replace => player = new(&mut source),
        }
        let clock = &player.clock;
        assert!((0.0..=clock.duration()).contains(&clock.seconds()), "{clock:?}");
        assert!(clock.rate().is_finite());
        assert!(player.pose().rotations.iter().all(|rotation| rotation.is_finite()));
        assert!(player.root().is_finite());
        assert!(
            QUALITY_LEVELS
                .iter()
                .any(|level| std::ptr::eq(level, player.quality()) || level.name == player.quality().name)
        );
    }
    Ok(())
}
