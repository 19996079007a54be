//! What comes out: tables of joints, and drawings in files.

use std::path::PathBuf;

use api::arms::{ArmDescription, ArmJointKind, ArmOutside};
use clap::Args;
use plots::Drawing;
use serde::Serialize;

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::thousandths;

/// Where a drawing goes.
#[derive(Args, Clone, Debug)]
pub(super) struct PlotArgs {
    /// Also draw the answer, as an SVG or a PNG by the file's ending.
    #[arg(long, value_name = "FILE.svg|png", value_parser = picture)]
    pub(super) plot: Option<Picture>,
}

/// A file for a drawing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    path: PathBuf,
    form: Form,
}

#[derive(Clone, Copy, Debug, Eq, PartialEq)]
enum Form {
    Svg,
    Png,
}

fn picture(text: &str) -> Result<Picture, String> {
    let path = PathBuf::from(text);
    let form = match path.extension().and_then(|extension| extension.to_str()) {
        Some("svg") => Form::Svg,
        Some("png") => Form::Png,
        Some(_) | None => return Err("its name must end in `.svg` or `.png`".to_owned()),
    };
    Ok(Picture { path, form })
}

impl Picture {
    fn write(&self, drawing: &Drawing) -> Result<(), Failure> {
        let bytes = match self.form {
            Form::Svg => drawing.svg().as_bytes().to_vec(),
            Form::Png => drawing.png()?,
        };
        std::fs::write(&self.path, bytes)
            .map_err(|error| Failure::Usage(format!("writing {}: {error}", self.path.display())))
    }
}

/// The answer for people or machines, and its drawing if one was asked for.
pub(super) fn finish<T: Serialize>(
    context: &Context,
    exit: Exit,
    answer: &T,
    drawing: Option<(&Picture, Drawing)>,
    text: impl FnOnce(&T) -> String,
) -> Result<Report, Failure> {
    let mut wrote = String::new();
    if let Some((picture, drawing)) = drawing {
        picture.write(&drawing)?;
        wrote = format!("\n\nWrote {}", picture.path.display());
    }
    Ok(context.report(exit, answer, |answer| {
        format!("{}{wrote}", text(answer).trim_end())
    }))
}

/// What was asked for is not what comes out: the answer says why.
pub(super) fn exit_if(possible: bool) -> Exit {
    if possible { Exit::Done } else { Exit::Refused }
}

/// The unit of a joint's value.
pub(super) fn unit(kind: ArmJointKind) -> &'static str {
    match kind {
        ArmJointKind::Revolute => "deg",
        ArmJointKind::Prismatic => "mm",
    }
}

/// `J1 0.000  J2 45.000 deg`, each with its unit where they differ.
pub(super) fn joints(arm: &ArmDescription, values: &[f64]) -> String {
    let alike = arm.joints.windows(2).all(|pair| match pair {
        [a, b] => a.kind == b.kind,
        _ => true,
    });
    let texts = arm.joints.iter().zip(values).map(|(joint, value)| {
        let value = thousandths(*value);
        if alike {
            format!("{} {value}", joint.name)
        } else {
            format!("{} {value} {}", joint.name, unit(joint.kind))
        }
    });
    let texts: Vec<String> = texts.collect();
    let all = texts.join("  ");
    match arm.joints.first() {
        Some(joint) if alike => format!("{all} {}", unit(joint.kind)),
        _ => all,
    }
}

/// What is wrong with joints, one a line.
pub(super) fn outside(joints: &[ArmOutside]) -> Vec<String> {
    joints
        .iter()
        .map(|joint| {
            format!(
                "{} is {}, outside its range {} to {}",
                joint.joint,
                thousandths(joint.value_deg_mm),
                thousandths(joint.min_deg_mm),
                thousandths(joint.max_deg_mm)
            )
        })
        .collect()
}

/// A point in a sentence.
pub(super) fn point([x, y, z]: [f64; 3]) -> String {
    let [x, y, z] = [x, y, z].map(thousandths);
    format!("X {x}  Y {y}  Z {z} mm")
}
