//! Programs from source to machine.

use karel::{Generation, IncludeFiles, Machine, Program};

use super::programs::{Loaded, ProgramKind};
use crate::config::{ControllerConfig, Limits, ProgramSource};
use crate::error::StartError;

/// Loads every program; what is loaded in the order given.
pub(super) fn load(
    machine: &mut Machine,
    programs: &[ProgramSource],
    includes: &[ProgramSource],
    generation: Generation,
    limits: Limits,
) -> Result<Vec<Loaded>, StartError> {
    if programs.is_empty() {
        return Err(StartError::NoProgram);
    }
    if programs.len() > limits.programs {
        return Err(StartError::TooManyPrograms {
            count: programs.len(),
            limit: limits.programs,
        });
    }
    let mut files = IncludeFiles::default();
    for ProgramSource { name, text } in includes {
        files.insert(name, text.as_slice());
    }
    let mut names = Vec::new();
    for ProgramSource { name: file, text } in programs {
        if text.len() > limits.program_bytes {
            return Err(StartError::ProgramTooLong {
                file: file.clone(),
                bytes: text.len(),
                limit: limits.program_bytes,
            });
        }
        let program =
            Program::from_file_for(text, file, &files, generation).map_err(|diagnostics| {
                let rendered: Vec<String> = diagnostics.iter().map(ToString::to_string).collect();
                StartError::Program {
                    file: file.clone(),
                    errors: diagnostics.len(),
                    rendered: rendered.join("\n"),
                }
            })?;
        for warning in program.warnings() {
            tracing::warn!("{warning}");
        }
        names.push(Loaded {
            name: program.name().to_owned(),
            kind: ProgramKind::of_file(file),
            file: file.clone(),
        });
        machine.load(program).map_err(|error| StartError::Load {
            file: file.clone(),
            reason: error.to_string(),
        })?;
    }
    for routine in machine.unresolved() {
        tracing::warn!("No loaded program has the routine {routine}; calling it ends the task.");
    }
    Ok(names)
}

/// The gripper's ports exist and differ.
pub(super) fn check_gripper(config: &ControllerConfig) -> Result<(), StartError> {
    let Some(gripper) = config.gripper else {
        return Ok(());
    };
    let last = config.ports.digital;
    let outputs = [("DOUT", gripper.close_output)];
    let inputs = [gripper.closed_input, gripper.open_input, gripper.part_input];
    let inputs = inputs.map(|number| ("DIN", number));
    for (name, number) in outputs.into_iter().chain(inputs) {
        if number == 0 || number > last {
            let what = format!("{name}[{number}], the last is {name}[{last}]");
            return Err(StartError::Gripper { what });
        }
    }
    let [(_, a), (_, b), (_, c)] = inputs;
    if a == b || a == c || b == c {
        let what = "one input for two things".to_owned();
        return Err(StartError::Gripper { what });
    }
    Ok(())
}
