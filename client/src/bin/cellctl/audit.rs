//! `cellctl audit`: who did what.

use api::AuditList;
use clap::Args;
use client::Page;

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{Table, word};

/// List who did what, newest first: control, stops, tokens, refused requests. For integrators and admins.
///
/// The journal has each entry in its chain of hashes; `cellctl journal verify` and `export` prove it from the file.
///
/// Examples:
///   cellctl audit
///   cellctl audit --limit 200 --json
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct AuditArgs {
    /// At most this many.
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    limit: Option<u32>,
    /// Where the page before said to go on.
    #[arg(long, value_name = "CURSOR")]
    cursor: Option<String>,
}

pub(crate) async fn run(args: AuditArgs, context: &Context) -> Result<Report, Failure> {
    let page = Page {
        limit: args.limit,
        cursor: args.cursor,
    };
    let list = context.client.audit(&context.cell().await?, &page).await?;
    Ok(context.report(Exit::Done, &list, table))
}

fn table(list: &AuditList) -> String {
    let mut table = Table::new(&["at", "who", "role", "what", "to what", "result", "more"]);
    for entry in &list.entries {
        table.row([
            format!("{:.0}", entry.at),
            entry.principal.clone(),
            entry.role.clone().unwrap_or_default(),
            entry.action.clone(),
            entry.object.clone(),
            word(entry.result),
            entry.after.clone().unwrap_or_default(),
        ]);
    }
    let text = if list.entries.is_empty() {
        "Nobody did anything yet, or nothing more.".to_owned()
    } else {
        table.to_string()
    };
    match &list.next_cursor {
        Some(cursor) => format!("{text}\nMore: cellctl audit --cursor {cursor}"),
        None => text,
    }
}
