//! Programs and tasks.

use axum::extract::{Json, Path, State as Shared};
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa_axum::{router::OpenApiRouter, routes};

use super::super::Visitors;
use super::parts::{AnyProblem, Refusal};
use crate::controller::{Controller, Lines, ProgramView, TaskError, TaskSeen};
use crate::driver::Driver;
use crate::state::TaskWord;
use crate::virtual_controller::visit;

pub(super) fn routes() -> OpenApiRouter<Visitors> {
    OpenApiRouter::new()
        .routes(routes!(list_programs))
        .routes(routes!(run_program))
        .routes(routes!(list_tasks))
        .routes(routes!(get_task))
        .routes(routes!(abort_task))
        .routes(routes!(pause_task))
        .routes(routes!(continue_task))
        .routes(routes!(step_task))
        .routes(routes!(abort_all))
}

/// The programs that are loaded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ProgramList {
    /// In the order in which they were given.
    pub programs: Vec<ProgramView>,
}

/// The tasks that exist.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TaskList {
    /// Oldest first, ended ones included.
    pub tasks: Vec<TaskDetail>,
}

/// A task with its call stack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TaskDetail {
    /// The task: its root program.
    pub name: String,
    /// What it does.
    pub state: TaskWord,
    /// Whether it is paused.
    pub paused: bool,
    /// What it waits for, or the error that ended it.
    pub detail: Option<String>,
    /// Where it is, innermost first.
    pub calls: Vec<CallView>,
}

/// One call of a stack.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct CallView {
    /// The program that has the routine.
    pub program: String,
    /// The routine; the program's name for its main body.
    pub routine: String,
    /// The line of the source.
    pub line: u32,
}

fn detail(seen: &TaskSeen) -> TaskDetail {
    let TaskSeen { view, paused, .. } = seen;
    let (state, detail) = crate::controller::task_in_words(&view.state, *paused);
    let call = |site: &karel::CallSite| CallView {
        program: site.program.to_string(),
        routine: site.routine.to_string(),
        line: site.line,
    };
    TaskDetail {
        name: view.name.to_string(),
        state,
        paused: *paused,
        detail,
        calls: view.calls.iter().map(call).collect(),
    }
}

/// Lists the programs that are loaded.
#[utoipa::path(get, path = "/api/v1/programs", tag = "programs",
    responses((status = 200, description = "The programs.", body = ProgramList), AnyProblem))]
async fn list_programs(Shared(visitors): Shared<Visitors>) -> Result<Json<ProgramList>, Refusal> {
    let ask = |driver: &mut Driver| driver.core.programs();
    let programs = visit(&visitors.commands, ask).await?;
    Ok(Json(ProgramList { programs }))
}

/// Starts a program as a task.
#[utoipa::path(post, path = "/api/v1/programs/{program}/run", tag = "programs",
    params(("program" = String, Path, description = "The program's name.")),
    responses((status = 200, description = "The task.", body = TaskDetail), AnyProblem))]
async fn run_program(
    Shared(visitors): Shared<Visitors>,
    Path(name): Path<String>,
) -> Result<Json<TaskDetail>, Refusal> {
    change(&visitors, name, Controller::run_program).await
}

/// Lists the tasks with their call stacks.
#[utoipa::path(get, path = "/api/v1/tasks", tag = "programs",
    responses((status = 200, description = "The tasks.", body = TaskList), AnyProblem))]
async fn list_tasks(Shared(visitors): Shared<Visitors>) -> Result<Json<TaskList>, Refusal> {
    let ask = |driver: &mut Driver| driver.core.tasks_seen().map(|seen| detail(&seen)).collect();
    let tasks = visit(&visitors.commands, ask).await?;
    Ok(Json(TaskList { tasks }))
}

/// Shows a task: where it is, and what it waits for.
#[utoipa::path(get, path = "/api/v1/tasks/{task}", tag = "programs",
    params(("task" = String, Path, description = "The task's name: that of its root program.")),
    responses((status = 200, description = "The task.", body = TaskDetail), AnyProblem))]
async fn get_task(
    Shared(visitors): Shared<Visitors>,
    Path(name): Path<String>,
) -> Result<Json<TaskDetail>, Refusal> {
    change(&visitors, name, |_, _| Ok(())).await
}

/// Aborts a task. The arm brakes if it moves for it; its connections stay open and silent.
#[utoipa::path(post, path = "/api/v1/tasks/{task}/abort", tag = "programs",
    params(("task" = String, Path, description = "The task's name.")),
    responses((status = 200, description = "The task.", body = TaskDetail), AnyProblem))]
async fn abort_task(
    Shared(visitors): Shared<Visitors>,
    Path(name): Path<String>,
) -> Result<Json<TaskDetail>, Refusal> {
    change(&visitors, name, Controller::abort_task).await
}

/// Pauses a task. The arm brakes on its path if it moves for it.
#[utoipa::path(post, path = "/api/v1/tasks/{task}/pause", tag = "programs",
    params(("task" = String, Path, description = "The task's name.")),
    responses((status = 200, description = "The task.", body = TaskDetail), AnyProblem))]
async fn pause_task(
    Shared(visitors): Shared<Visitors>,
    Path(name): Path<String>,
) -> Result<Json<TaskDetail>, Refusal> {
    change(&visitors, name, Controller::pause_task).await
}

/// Lets a paused task go on.
#[utoipa::path(post, path = "/api/v1/tasks/{task}/continue", tag = "programs",
    params(("task" = String, Path, description = "The task's name.")),
    responses((status = 200, description = "The task.", body = TaskDetail), AnyProblem))]
async fn continue_task(
    Shared(visitors): Shared<Visitors>,
    Path(name): Path<String>,
) -> Result<Json<TaskDetail>, Refusal> {
    let go_on = |core: &mut Controller, name: &str| core.continue_task(name, Lines::All);
    change(&visitors, name, go_on).await
}

/// Lets a paused task execute one line.
#[utoipa::path(post, path = "/api/v1/tasks/{task}/step", tag = "programs",
    params(("task" = String, Path, description = "The task's name.")),
    responses((status = 200, description = "The task, which may not have finished the line yet.", body = TaskDetail), AnyProblem))]
async fn step_task(
    Shared(visitors): Shared<Visitors>,
    Path(name): Path<String>,
) -> Result<Json<TaskDetail>, Refusal> {
    let step = |core: &mut Controller, name: &str| core.continue_task(name, Lines::One);
    change(&visitors, name, step).await
}

/// Aborts all tasks; connections close.
#[utoipa::path(post, path = "/api/v1/abort-all", tag = "programs",
    responses((status = 204, description = "Nothing runs."), AnyProblem))]
async fn abort_all(Shared(visitors): Shared<Visitors>) -> Result<StatusCode, Refusal> {
    visit(&visitors.commands, |driver| driver.core.abort_all()).await?;
    Ok(StatusCode::NO_CONTENT)
}

async fn change(
    visitors: &Visitors,
    name: String,
    change: impl FnOnce(&mut Controller, &str) -> Result<(), TaskError> + Send + 'static,
) -> Result<Json<TaskDetail>, Refusal> {
    let changed = visit(&visitors.commands, move |driver| {
        change(&mut driver.core, &name)?;
        let seen = driver.core.task(&name)?;
        Ok::<_, TaskError>(detail(&seen))
    });
    Ok(Json(changed.await??))
}
