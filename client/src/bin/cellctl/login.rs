//! `cellctl login`, `logout` and `whoami`.

use std::io::{self, BufRead as _, IsTerminal as _, Read as _, Write as _};

use api::{Me, Role, TokenSecret};
use serde::Serialize;

use crate::context::Context;
use crate::credentials;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text;

/// The longest line taken for a token, in bytes.
const MAX_LINE: u64 = 1024;

#[derive(Debug, Serialize)]
struct LoggedIn {
    #[serde(flatten)]
    me: Me,
    #[serde(skip_serializing_if = "Option::is_none")]
    kept_in: Option<String>,
}

/// Asks for a token, tries it, and keeps it.
pub(crate) async fn login(context: &Context) -> Result<Report, Failure> {
    let token = match context.token_file() {
        Some(path) => credentials::read_token(path)?,
        None => ask().map_err(|error| Failure::Usage(format!("reading the token: {error}")))?,
    };
    let me = context.client.with_token(&token)?.me().await?;
    let kept_in = if me.demo {
        None
    } else {
        let path = credentials::keep(context.server(), &me.name, token)?;
        Some(path.display().to_string())
    };
    let answer = LoggedIn { me, kept_in };
    Ok(
        context.report(Exit::Done, &answer, |answer| match &answer.kept_in {
            None => {
                "The server runs in demo mode: no token is needed, and none was kept.".to_owned()
            }
            Some(path) => format!("{}\nThe token is kept in {path}.", sentences(&answer.me)),
        }),
    )
}

/// Forgets the token that was kept.
pub(crate) fn logout(context: &Context) -> Result<Report, Failure> {
    #[derive(Serialize)]
    struct LoggedOut {
        name: Option<String>,
    }
    let name = credentials::forget(context.server())?;
    Ok(context.report(Exit::Done, &LoggedOut { name }, |out| match &out.name {
        Some(name) => format!("The token of `{name}` is forgotten here. It is still valid: `cellctl tokens revoke` ends it."),
        None => "No token of this server was kept.".to_owned(),
    }))
}

/// Shows who the server takes us for.
pub(crate) async fn whoami(context: &Context) -> Result<Report, Failure> {
    let me = context.client.me().await?;
    Ok(context.report(Exit::Done, &me, sentences))
}

fn sentences(me: &Me) -> String {
    let roles: Vec<_> = me.roles.iter().map(|role| role.as_str()).collect();
    let mut facts = vec![("name", me.name.clone()), ("role", roles.join(", "))];
    if let Some(cell) = &me.scope.cell {
        facts.push(("cell", cell.clone()));
    }
    if let Some(robot) = &me.scope.mobile_robot {
        facts.push(("mobile robot", robot.clone()));
    }
    if me.scope.local_station {
        facts.push(("station", "LOCAL: may always take control".to_owned()));
    }
    if let Some(token) = &me.token {
        facts.push(("token", token.clone()));
    }
    if let Some(at) = me.expires_at {
        facts.push(("expires", format!("{at:.0}")));
    }
    let mut said = text::facts(&facts);
    if me.demo {
        said.push_str(
            "\nThe server runs in demo mode: everybody on its machine may do everything.",
        );
    } else if me.roles == [Role::Admin] {
        said.push_str(
            "\nAn admin moves nothing. `cellctl tokens create NAME --role operator` makes somebody who does.",
        );
    }
    said
}

/// Reads a line, without showing it where a person types it.
fn ask() -> io::Result<TokenSecret> {
    let stdin = io::stdin();
    let quiet = if stdin.is_terminal() {
        let mut terminal = io::stderr();
        write!(terminal, "Token (is not shown): ")?;
        terminal.flush()?;
        Some(Quiet::new()?)
    } else {
        None
    };
    let mut line = String::new();
    let read = stdin.lock().take(MAX_LINE).read_line(&mut line);
    if quiet.is_some() {
        drop(quiet);
        writeln!(io::stderr())?;
    }
    let _length = read?;
    match line.trim() {
        "" => Err(io::Error::new(
            io::ErrorKind::UnexpectedEof,
            "there is none",
        )),
        token => Ok(TokenSecret::new(token.to_owned())),
    }
}

/// A terminal that does not show what is typed, until this is dropped.
#[cfg(unix)]
struct Quiet(rustix::termios::Termios);

#[cfg(unix)]
impl Quiet {
    fn new() -> io::Result<Self> {
        use rustix::termios::{LocalModes, OptionalActions, tcgetattr, tcsetattr};
        let before = tcgetattr(io::stdin())?;
        let mut quiet = before.clone();
        quiet.local_modes.remove(LocalModes::ECHO);
        tcsetattr(io::stdin(), OptionalActions::Now, &quiet)?;
        Ok(Self(before))
    }
}

#[cfg(unix)]
impl Drop for Quiet {
    fn drop(&mut self) {
        use rustix::termios::{OptionalActions, tcsetattr};
        // A terminal that is gone shows nothing either.
        let _ = tcsetattr(io::stdin(), OptionalActions::Now, &self.0);
    }
}

#[cfg(not(unix))]
struct Quiet;

#[cfg(not(unix))]
impl Quiet {
    fn new() -> io::Result<Self> {
        Ok(Self)
    }
}
