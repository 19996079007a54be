//! `cellctl control`: who may move the robots of a cell.

use std::io::Write as _;

use api::{AcquireBody, ControlLease, ControlToken, ControlView, LossBehavior, Station};
use clap::{Args, Subcommand, ValueEnum};

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{self, word};

/// Show who has control of the cell, take it, or give it back.
///
/// Commands that move take control by themselves for as long as they need it. Take it here to keep others, and the
/// cell's jobs, from moving meanwhile.
///
/// Examples:
///   cellctl control
///   cellctl control take --hold --reason "teaching the rack"
///   cellctl control release
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct ControlArgs {
    #[command(subcommand)]
    command: Option<ControlCommand>,
}

#[derive(Debug, Subcommand)]
enum ControlCommand {
    /// Show who has control.
    Show,
    /// Take control.
    Take(TakeArgs),
    /// Give control back.
    Release {
        /// The token that `take` printed; the present holder's where absent.
        token: Option<ControlToken>,
    },
}

#[derive(Args, Debug)]
struct TakeArgs {
    /// Control is lost this many seconds after the last heartbeat.
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u32).range(2..=60))]
    ttl_s: Option<u32>,
    /// Stand at the cell itself and take control from anybody. Needs a token made for that.
    #[arg(long)]
    local: bool,
    /// Take control away from whoever has it. For admins.
    #[arg(long)]
    preempt: bool,
    /// What becomes of motions under way when control is lost.
    #[arg(long, value_enum)]
    on_loss: Option<OnLoss>,
    /// Why, for whoever waits and for the record.
    #[arg(long, value_name = "TEXT", default_value = "cellctl control take")]
    reason: String,
    /// Print the token and keep control until Ctrl-C.
    #[arg(long)]
    hold: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum OnLoss {
    /// They pause.
    Hold,
    /// They end by a controlled stop.
    Stop1,
    /// They end where they were going; nothing further is sent.
    CompleteStep,
}

pub(crate) async fn run(args: ControlArgs, context: &Context) -> Result<Report, Failure> {
    let cell = context.cell().await?;
    let control = context.client.control(&cell);
    match args.command {
        None | Some(ControlCommand::Show) => {
            let view = control.show().await?;
            Ok(context.report(Exit::Done, &view, sentences))
        }
        Some(ControlCommand::Release { token }) => {
            let lease = match token {
                Some(token) => Some(token.lease),
                None => control.show().await?.held.map(|held| held.lease),
            };
            let view = match lease {
                Some(lease) => control.release(lease).await?,
                None => control.show().await?,
            };
            Ok(context.report(Exit::Done, &view, sentences))
        }
        Some(ControlCommand::Take(args)) => take(&args, context, &control).await,
    }
}

async fn take(
    args: &TakeArgs,
    context: &Context,
    control: &client::Control,
) -> Result<Report, Failure> {
    let body = AcquireBody {
        station: if args.local {
            Station::Local
        } else {
            Station::Remote
        },
        ttl_s: args.ttl_s,
        loss_behavior: args.on_loss.map(|behavior| match behavior {
            OnLoss::Hold => LossBehavior::Hold,
            OnLoss::Stop1 => LossBehavior::Stop1,
            OnLoss::CompleteStep => LossBehavior::CompleteStep,
        }),
        reason: args.reason.clone(),
        preempt: args.preempt,
    };
    if !args.hold {
        let lease = control.acquire(&body).await?;
        return Ok(context.report(Exit::Done, &lease, taken));
    }
    let held = control.hold(&body).await?;
    let mut out = std::io::stdout();
    // Whoever reads the token through a pipe needs it now, and nothing else.
    let said = writeln!(out, "{}", held.token()).and_then(|()| out.flush());
    if let Err(error) = said {
        let _view = held.release().await?;
        return Err(Failure::Usage(format!("printing the token: {error}")));
    }
    tokio::select! {
        lost = held.lost() => Err(Failure::ControlLost(lost)),
        _ = tokio::signal::ctrl_c() => {
            let view = held.release().await?;
            Ok(context.report(Exit::Done, &view, sentences))
        }
    }
}

fn taken(lease: &ControlLease) -> String {
    format!(
        "{}\n\nControl is yours for {} s: `cellctl move … --control TOKEN`, or the header `Control-Token`.",
        lease.token, lease.ttl_s
    )
}

fn sentences(view: &ControlView) -> String {
    let mut facts = vec![("cell", view.cell.clone())];
    match &view.held {
        Some(held) => facts.extend([
            (
                "control",
                format!("{} ({})", held.holder, word(held.station)),
            ),
            ("reason", held.reason.clone()),
            ("since", format!("{:.0}", held.since)),
            (
                "until",
                format!("{:.0}, unless a heartbeat comes", held.expires),
            ),
            ("on loss", word(held.loss_behavior)),
            ("token", held.token.to_string()),
        ]),
        None => facts.push(("control", "free: jobs may move the robots".to_owned())),
    }
    if let Some(last) = &view.last {
        let by = last.by.as_deref().map(|by| format!(" by {by}"));
        facts.push((
            "before",
            format!(
                "{}, {}{} at {:.0}",
                last.holder,
                word(last.end),
                by.unwrap_or_default(),
                last.at
            ),
        ));
    }
    text::facts(&facts)
}
