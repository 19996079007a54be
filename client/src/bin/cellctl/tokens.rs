//! `cellctl tokens`: who may call the server.

use api::{NewToken, Role, TokenBody, TokenInfo, TokenList, TokenScope};
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand};

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{self, Table, word};

/// List, make, revoke and rotate the server's tokens. For admins.
///
/// Examples:
///   cellctl tokens
///   cellctl tokens create alice --role operator
///   cellctl tokens create panel --role operator --in-cell demo --local-station
///   cellctl tokens revoke 0123456789abcdef
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct TokensArgs {
    #[command(subcommand)]
    command: Option<TokensCommand>,
}

#[derive(Debug, Subcommand)]
enum TokensCommand {
    /// List the tokens, newest first.
    List,
    /// Make a token and show it, this once.
    Create(CreateArgs),
    /// End a token at once.
    Revoke {
        /// The token's id: the part between the underscores.
        id: String,
    },
    /// Give a token a new secret and show it, this once.
    Rotate {
        /// The token's id: the part between the underscores.
        id: String,
        /// How long the old one stays valid.
        #[arg(long, value_name = "SECONDS", default_value_t = 0)]
        overlap_s: u32,
    },
}

#[derive(Args, Debug)]
struct CreateArgs {
    /// Who will hold it, for logs and records.
    name: String,
    /// What its holder may do.
    #[arg(long, value_parser = PossibleValuesParser::new(Role::ALL.map(Role::as_str)))]
    role: String,
    /// The only cell it sees.
    #[arg(long, value_name = "ID")]
    in_cell: Option<String>,
    /// The mobile robot it is, for the role `mobile_robot`.
    #[arg(long, value_name = "ID")]
    mobile_robot: Option<String>,
    /// It is for the cell's own panel, which may always take control.
    #[arg(long)]
    local_station: bool,
    /// For how many days it is valid, 1 to 365; 90 where absent.
    #[arg(long, value_name = "DAYS")]
    days: Option<u32>,
}

pub(crate) async fn run(args: TokensArgs, context: &Context) -> Result<Report, Failure> {
    let client = &context.client;
    match args.command {
        None | Some(TokensCommand::List) => {
            let tokens = client.tokens().await?;
            Ok(context.report(Exit::Done, &tokens, table))
        }
        Some(TokensCommand::Create(args)) => {
            let made = client.create_token(&body(args)?).await?;
            Ok(context.report(Exit::Done, &made, shown_once))
        }
        Some(TokensCommand::Revoke { id }) => {
            let revoked = client.revoke_token(&id).await?;
            Ok(context.report(Exit::Done, &revoked, |token| {
                format!("The token opens nothing any more.\n{}", facts(token))
            }))
        }
        Some(TokensCommand::Rotate { id, overlap_s }) => {
            let made = client.rotate_token(&id, overlap_s).await?;
            Ok(context.report(Exit::Done, &made, shown_once))
        }
    }
}

fn body(args: CreateArgs) -> Result<TokenBody, Failure> {
    let role = Role::of_str(&args.role);
    let role = role.ok_or_else(|| Failure::Usage(format!("there is no role `{}`", args.role)))?;
    Ok(TokenBody {
        name: args.name,
        role,
        scope: TokenScope {
            cell: args.in_cell,
            mobile_robot: args.mobile_robot,
            local_station: args.local_station,
        },
        expires_in_days: args.days,
    })
}

fn shown_once(made: &NewToken) -> String {
    format!(
        "{}\n\nThis is the only time it is shown. Its holder keeps it with `cellctl login`.\n{}",
        made.token.reveal(),
        facts(&made.info)
    )
}

fn facts(token: &TokenInfo) -> String {
    text::facts(&[
        ("id", token.id.clone()),
        ("name", token.name.clone()),
        ("role", token.role.to_string()),
        ("scope", scope(&token.scope)),
        ("state", word(token.state)),
        ("expires", format!("{:.0}", token.expires_at)),
    ])
}

fn scope(scope: &TokenScope) -> String {
    let mut said = vec![match &scope.cell {
        Some(cell) => format!("cell {cell}"),
        None => "every cell".to_owned(),
    }];
    said.extend(
        scope
            .mobile_robot
            .as_ref()
            .map(|id| format!("mobile robot {id}")),
    );
    said.extend(scope.local_station.then(|| "LOCAL".to_owned()));
    said.join(", ")
}

fn table(list: &TokenList) -> String {
    let mut table = Table::new(&["id", "name", "role", "scope", "state", "expires", "by"]);
    for token in &list.tokens {
        table.row([
            token.id.clone(),
            token.name.clone(),
            token.role.to_string(),
            scope(&token.scope),
            word(token.state),
            format!("{:.0}", token.expires_at),
            token.created_by.clone(),
        ]);
    }
    table.to_string()
}
