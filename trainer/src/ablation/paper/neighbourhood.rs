//! Which points a quadratic is fitted to, in the paper's form.

use super::super::measured_avatar;
use super::{Add, Runs};
use crate::appearance::bake;
use crate::context::{DeformationTrainer, LaplacianTrainer};
use crate::options::Neighbourhood;
use crate::plain::{PlainDeformation, PlainLaplacian};
use crate::progress::Progress;
use crate::refinement::refine_poses;
use crate::train::{Facts, assemble};

/// The paper takes 20 to 30 nearest points; a radius does not shrink as scans grow denser, and noise does not grow.
const NEIGHBOURHOODS: [Neighbourhood; 6] = [
    Neighbourhood::Nearest(15),
    Neighbourhood::Nearest(25),
    Neighbourhood::Nearest(60),
    Neighbourhood::Radius(0.012),
    Neighbourhood::Radius(0.02),
    Neighbourhood::Radius(0.03),
];

/// One f_d, and an f_l for each neighbourhood.
pub fn neighbourhoods(runs: &Runs, add: &mut Add) -> anyhow::Result<()> {
    let mut context = runs.paper.prepare(Progress::Bars)?;
    refine_poses(&mut context)?;
    let frames = runs.test.indices(context.sequences[0].capture.frame_count)?;
    let facts = Facts { name: context.sequences[0].capture.name.clone(), ..Facts::default() };
    let deformation = PlainDeformation.train(&context)?.adopt(&mut context);
    let appearance = bake(&context, &deformation)?;
    for (index, neighbourhood) in NEIGHBOURHOODS.into_iter().enumerate() {
        context.options.quadratic.neighbourhood = neighbourhood;
        let laplacian = PlainLaplacian.train(&context, &deformation)?;
        let avatar = assemble(&context, &facts, deformation.clone(), laplacian, appearance.clone())?;
        let evaluation = measured_avatar(&avatar, &context.sequences[0], &frames)?.1;
        let base = (index == 0).then_some(evaluation.base);
        add(&name(neighbourhood), base, Some(evaluation.detailed), None);
    }
    Ok(())
}

fn name(neighbourhood: Neighbourhood) -> String {
    match neighbourhood {
        Neighbourhood::Nearest(count) => format!("{count} nearest"),
        Neighbourhood::Radius(radius) => format!("{:.0} mm", 1e3 * radius),
    }
}
