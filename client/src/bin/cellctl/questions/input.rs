//! What goes in: lists of numbers, frames, questions in files.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use api::PoseBody;
use api::arms::{ArmFrames, ArmSolver, ArmTask};
use clap::{Args, ValueEnum};
use serde::de::DeserializeOwned;

use super::show::PlotArgs;
use crate::failure::Failure;
use crate::numbers::finite;

/// The largest question that is read.
const MAX_BYTES: u64 = 16 * 1024 * 1024;

/// Numbers in a row: `0,45,-60`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Numbers(pub(super) Vec<f64>);

impl FromStr for Numbers {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split(',').enumerate().map(|(index, part)| {
            finite(part.trim()).map_err(|why| {
                let at = index + 1;
                format!("number {at}, `{}`, is {why}", part.trim())
            })
        });
        numbers.collect::<Result<_, _>>().map(Self)
    }
}

/// Exactly so many numbers: `0,0,5000,3000`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row<const N: usize>(pub(super) [f64; N]);

impl<const N: usize> FromStr for Row<N> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Numbers(numbers) = text.parse()?;
        let given = numbers.len();
        let row = numbers.try_into();
        row.map(Self)
            .map_err(|_| format!("{given} numbers were given; it must be {N} of them, with commas"))
    }
}

impl From<Row<6>> for PoseBody {
    fn from(Row(numbers): Row<6>) -> Self {
        numbers.into()
    }
}

/// The frames of poses.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct FrameArgs {
    /// The tool on the flange: X, Y, Z in mm and W, P, R in degrees. The flange itself if absent.
    #[arg(long, value_name = "X,Y,Z,W,P,R", allow_hyphen_values = true)]
    tool: Option<Row<6>>,
    /// The user frame in the arm's world. The world itself if absent.
    #[arg(long, value_name = "X,Y,Z,W,P,R", allow_hyphen_values = true)]
    user_frame: Option<Row<6>>,
}

impl From<FrameArgs> for ArmFrames {
    fn from(FrameArgs { tool, user_frame }: FrameArgs) -> Self {
        Self {
            user_frame: user_frame.map(PoseBody::from),
            tool: tool.map(PoseBody::from),
        }
    }
}

/// What of the tool's pose or motion counts.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum TaskArg {
    /// Position and rotation.
    Pose,
    /// Position, and where the tool's Z points.
    PositionAndAxis,
    /// Position, and the turn about Z.
    PositionAndHeading,
    /// The position only.
    Position,
}

impl From<TaskArg> for ArmTask {
    fn from(task: TaskArg) -> Self {
        match task {
            TaskArg::Pose => Self::Pose,
            TaskArg::PositionAndAxis => Self::PositionAndAxis,
            TaskArg::PositionAndHeading => Self::PositionAndHeading,
            TaskArg::Position => Self::Position,
        }
    }
}

/// How inverse kinematics are solved.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodArg {
    /// Ortho-parallel arms with a spherical wrist.
    ClosedForm,
    /// Six revolute joints with a spherical wrist, through the quartic in tan(q3/2).
    Quartic,
    /// The textbook's arm, geometrically.
    Textbook,
    /// The paper's five-link arm.
    FiveLink,
    /// Any arm, by damped least squares.
    DampedLeastSquares,
}

impl From<MethodArg> for ArmSolver {
    fn from(method: MethodArg) -> Self {
        match method {
            MethodArg::ClosedForm => Self::ClosedForm,
            MethodArg::Quartic => Self::Quartic,
            MethodArg::Textbook => Self::Textbook,
            MethodArg::FiveLink => Self::FiveLink,
            MethodArg::DampedLeastSquares => Self::DampedLeastSquares,
        }
    }
}

/// The question in a file instead of options.
#[derive(Args, Clone, Debug)]
pub(super) struct FileArgs {
    /// The question as the HTTP API takes it, in a `.json` or `.toml` file; `-` reads JSON from the standard input.
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
}

/// An arm at given joints.
#[derive(Args, Clone, Debug)]
pub(super) struct PostureArgs {
    /// The model.
    pub(super) model: String,
    /// The joint values, base first.
    #[arg(allow_negative_numbers = true, value_parser = finite, required_unless_present = "file",
        conflicts_with = "file")]
    pub(super) joints: Vec<f64>,
}

/// How inverse kinematics are solved, and for what.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct SolverArgs {
    /// How to solve; the best that the model has if absent.
    #[arg(long, value_enum)]
    method: Option<MethodArg>,
    /// What of the poses counts, by damped least squares; what the model can do if absent.
    #[arg(long, value_enum)]
    task: Option<TaskArg>,
}

impl SolverArgs {
    pub(super) fn method(self) -> Option<ArmSolver> {
        self.method.map(Into::into)
    }

    pub(super) fn task(self) -> Option<ArmTask> {
        self.task.map(Into::into)
    }
}

/// What every question about poses ends with: frames, a file, a drawing.
#[derive(Args, Clone, Debug)]
pub(super) struct AskArgs {
    #[command(flatten)]
    pub(super) frames: FrameArgs,
    #[command(flatten)]
    pub(super) file: FileArgs,
    #[command(flatten)]
    pub(super) plot: PlotArgs,
}

impl FileArgs {
    /// The question in the file, or else that of the options.
    ///
    /// # Errors
    /// The file's, or the options'.
    pub(super) fn question<T: DeserializeOwned>(
        &self,
        of_options: impl FnOnce() -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        match &self.file {
            Some(file) => read(file),
            None => of_options(),
        }
    }
}

/// Reads a question.
///
/// # Errors
/// It cannot be read, or is none: with the item that is wrong.
fn read<T: DeserializeOwned>(path: &Path) -> Result<T, Failure> {
    let shown = path.display();
    let unreadable = |error: std::io::Error| Failure::Usage(format!("reading {shown}: {error}"));
    let mut bytes = Vec::new();
    let _read = if path == Path::new("-") {
        std::io::stdin()
            .lock()
            .take(MAX_BYTES + 1)
            .read_to_end(&mut bytes)
    } else {
        std::fs::File::open(path)
            .map_err(unreadable)?
            .take(MAX_BYTES + 1)
            .read_to_end(&mut bytes)
    }
    .map_err(unreadable)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(Failure::Usage(format!(
            "{shown} has more than {MAX_BYTES} bytes"
        )));
    }
    let text = String::from_utf8(bytes)
        .map_err(|_| Failure::Usage(format!("{shown} is not UTF-8 text")))?;
    let extension = path.extension().and_then(|extension| extension.to_str());
    let wrong = |path: &serde_path_to_error::Path, why: &str| {
        let why = why.trim_end();
        let item = path.to_string();
        if item == "." {
            Failure::Usage(format!("{shown}: {why}"))
        } else {
            Failure::Usage(format!("{shown}: {item}: {why}"))
        }
    };
    match extension {
        Some("toml") => {
            let reader = toml::Deserializer::parse(&text).map_err(|error| {
                Failure::Usage(format!("{shown}: {}", error.to_string().trim_end()))
            })?;
            serde_path_to_error::deserialize(reader)
                .map_err(|error| wrong(error.path(), error.inner().message()))
        }
        Some("json") | None => {
            let mut reader = serde_json::Deserializer::from_str(&text);
            let question = serde_path_to_error::deserialize(&mut reader)
                .map_err(|error| wrong(error.path(), &error.inner().to_string()))?;
            reader
                .end()
                .map_err(|error| Failure::Usage(format!("{shown}: {error}")))?;
            Ok(question)
        }
        Some(other) => Err(Failure::Usage(format!(
            "{shown} ends in `.{other}`; a question is a `.json` or a `.toml` file"
        ))),
    }
}

/// An option that is needed without a file: clap knows nothing of that.
pub(super) fn needed<T>(value: Option<T>, option: &str) -> Result<T, Failure> {
    value.ok_or_else(|| {
        Failure::Usage(format!(
            "{option} is missing; give it, or the whole question with --file"
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_their_length() {
        assert_eq!("1, -2,3.5".parse(), Ok(Row([1.0, -2.0, 3.5])));
        let wrong: Result<Row<3>, String> = "1,2".parse();
        assert_eq!(
            wrong,
            Err("2 numbers were given; it must be 3 of them, with commas".to_owned())
        );
        let wrong: Result<Numbers, String> = "1,x,3".parse();
        assert!(
            wrong
                .unwrap_err()
                .starts_with("number 2, `x`, is not a number")
        );
        let wrong: Result<Numbers, String> = "1,nan".parse();
        assert_eq!(
            wrong,
            Err("number 2, `nan`, is not a finite number".to_owned())
        );
        let wrong: Result<Numbers, String> = "1,,3".parse();
        assert!(wrong.unwrap_err().starts_with("number 2, ``"));
    }
}
