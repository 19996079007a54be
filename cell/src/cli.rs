use std::path::PathBuf;

use clap::Parser;

/// A networked robot-cell server with virtual FANUC controllers and virtual mobile robots.
///
/// Without a configuration file it is the demo: a cell with one virtual FANUC M-20iA, one virtual mobile robot, two
/// stations and four loads, a second arm with the thesis's own KAREL program, and the HTTP API in front of them;
/// `robocell --demo` starts it. Nothing real moves unless a configuration names a real controller, and only callers
/// with a token move anything: the first start makes one and shows it. This is not a safety function.
#[derive(Debug, Parser)]
#[command(name = "robocell", version)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a flag of the command line"
)]
pub struct Cli {
    /// Configuration file (TOML). The demo where absent.
    #[arg(long, env = "ROBOCELL_CONFIG", value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Where to serve HTTP, `address:port`. Overrides `server.listen`.
    #[arg(long, env = "ROBOCELL_LISTEN", value_name = "ADDRESS")]
    pub(crate) listen: Option<String>,
    /// What to log on standard error, such as `info` or `server=debug`.
    #[arg(
        long,
        env = "ROBOCELL_LOG",
        default_value = "info",
        value_name = "FILTER"
    )]
    pub(crate) log: String,
    /// Let everybody on this machine do everything, without tokens. For trying things out, never for a real robot.
    #[arg(long, env = "ROBOCELL_DEMO")]
    pub(crate) demo: bool,
    /// Run the server in a process of its own beside the virtual parts, and start it again whenever it dies: its plug
    /// can be pulled (`kill -9`) while the virtual world goes on.
    #[arg(long)]
    pub(crate) supervised: bool,
    /// Make a new admin token and show it once: for whoever has this machine but no token any more.
    #[arg(long, conflicts_with_all = ["demo", "check"])]
    pub(crate) new_admin_token: bool,
    /// Read and check the configuration, and start nothing.
    #[arg(long, conflicts_with = "supervised")]
    pub(crate) check: bool,
    /// Play the job on standard input in virtual time, and write what became of it.
    #[arg(long, hide = true)]
    pub(crate) simulate: bool,
    /// Where the virtual controllers of a supervising process are, as JSON.
    #[arg(long, hide = true, value_name = "JSON")]
    pub(crate) parts_at: Option<String>,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }
}
