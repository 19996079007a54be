//! `cellctl cells`.

use api::CellSummary;

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{Table, word};

pub(crate) async fn run(context: &Context) -> Result<Report, Failure> {
    let cells = context.client.cells().await?;
    Ok(context.report(Exit::Done, &cells, |cells| table(cells)))
}

fn table(cells: &[CellSummary]) -> String {
    let mut table = Table::new(&["cell", "robot", "name", "model", "tier"]);
    for cell in cells {
        for robot in &cell.robots {
            table.row([
                cell.id.clone(),
                robot.id.clone(),
                robot.name.clone(),
                robot.model.clone(),
                word(robot.tier),
            ]);
        }
    }
    table.to_string()
}
