//! Idle memory of the whole demo cell, and the time from its start to its first answer.
//!
//! `robocell` must have been built in release mode; `cargo xtask bench footprint` does both.

use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, ensure};

/// How often the cell is started.
const STARTS: usize = 11;
/// The longest a start may take before this gives up.
const PATIENCE: Duration = Duration::from_secs(10);

#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
fn main() -> Result<()> {
    let binary = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/release/robocell");
    ensure!(
        binary.exists(),
        "{} is missing: cargo build --release -p cell",
        binary.display()
    );
    let mut first_answers = Vec::new();
    let mut memories = Vec::new();
    for _ in 0..STARTS {
        let cell = Cell::start(&binary)?;
        first_answers.push(cell.first_answer()?);
        // One motion, so that every part has worked once; then what stays resident.
        cell.post("/fanuc/home", "")?;
        memories.push(cell.resident_kib()?);
    }
    first_answers.sort_unstable();
    memories.sort_unstable();
    let middle = STARTS / 2;
    println!(
        "the demo cell (server, embedded virtual controller, panel), median of {STARTS} starts"
    );
    if let (Some(answer), Some(memory)) = (first_answers.get(middle), memories.get(middle)) {
        println!(
            "  first answer after start   {:>8.1} ms",
            answer.as_secs_f64() * 1e3
        );
        println!(
            "  resident memory, idle      {:>8.1} MiB",
            f64::from(*memory) / 1024.0
        );
    }
    Ok(())
}

/// A demo cell that ends when this is dropped.
struct Cell {
    process: Child,
    started: Instant,
    http: SocketAddr,
    config: PathBuf,
}

impl Cell {
    fn start(binary: &Path) -> Result<Self> {
        let [http, panel, robot] = free_ports()?;
        let config = std::env::temp_dir().join(format!("robocell-footprint-{}.toml", http.port()));
        std::fs::write(
            &config,
            format!(
                "[server]\nlisten = \"{http}\"\n[[cells]]\nid = \"demo\"\n[[cells.robots]]\nid = \"r1\"\n\
                 model = \"fanuc-m20ia\"\ncontroller = \"virtual:vc1\"\n[[virtual_controllers]]\nname = \"vc1\"\n\
                 model = \"fanuc-m20ia\"\npanel = \"{panel}\"\nports = {{ 59002 = {} }}\n",
                robot.port()
            ),
        )?;
        let started = Instant::now();
        let process = Command::new(binary)
            .arg("--config")
            .arg(&config)
            .stdout(Stdio::null())
            .spawn()
            .context("starting robocell")?;
        Ok(Self {
            process,
            started,
            http,
            config,
        })
    }

    /// Asks again and again until somebody answers.
    fn first_answer(&self) -> Result<Duration> {
        while self.started.elapsed() < PATIENCE {
            if self
                .exchange("GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
                .is_ok()
            {
                return Ok(self.started.elapsed());
            }
            std::thread::yield_now();
        }
        anyhow::bail!("no answer within {PATIENCE:?}")
    }

    fn post(&self, path: &str, body: &str) -> Result<()> {
        self.exchange(&format!(
            "POST {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        ))
    }

    fn exchange(&self, request: &str) -> Result<()> {
        let mut stream = TcpStream::connect(self.http)?;
        stream.write_all(request.as_bytes())?;
        let mut answer = String::new();
        let _length = stream.read_to_string(&mut answer)?;
        ensure!(answer.starts_with("HTTP/1.1 200"), "answered {answer:?}");
        Ok(())
    }

    /// `VmRSS` of the process, in KiB.
    fn resident_kib(&self) -> Result<u32> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.process.id()))?;
        let line = status
            .lines()
            .find(|line| line.starts_with("VmRSS:"))
            .context("VmRSS")?;
        let number = line.split_whitespace().nth(1).context("a number")?;
        Ok(number.parse()?)
    }
}

impl Drop for Cell {
    fn drop(&mut self) {
        // It may have ended by itself; then there is nothing to end.
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_file(&self.config);
    }
}

/// Three ports that were free a moment ago.
fn free_ports() -> Result<[SocketAddr; 3]> {
    let bind = || TcpListener::bind((Ipv4Addr::LOCALHOST, 0));
    let listeners = [bind()?, bind()?, bind()?];
    let [a, b, c] = listeners.each_ref().map(TcpListener::local_addr);
    Ok([a?, b?, c?])
}
