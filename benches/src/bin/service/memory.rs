//! Resident memory with 8 robots and 64 streams of events.

use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, TcpStream};

use anyhow::Result;

use crate::client::{Client, get};
use crate::probe::memory_mib;
use crate::served::CELL;

const STREAMS: usize = 64;
/// MiB at most.
pub(crate) const TARGET_MIB: f64 = 64.0;
/// MiB at most while it is attacked.
pub(crate) const TARGET_ATTACKED_MIB: f64 = 128.0;

/// What was measured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Memory {
    pub(crate) idle_mib: f64,
    pub(crate) with_streams_mib: f64,
    /// Whether they were streams of events; else connections that idle after an answer.
    pub(crate) streams: bool,
}

pub(crate) fn measure(port: u16, process: u32) -> Result<Memory> {
    let idle_mib = memory_mib(process, "VmRSS")?;
    let events = get(&format!("/api/v1/cells/{CELL}/events"));
    let mut probe = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
    probe.write_all(&events)?;
    let mut head = [0_u8; 12];
    probe.read_exact(&mut head)?;
    drop(probe);
    let streams = head.ends_with(b"200");
    let mut open = Vec::new();
    for _ in 0..STREAMS {
        if streams {
            let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
            stream.write_all(&events)?;
            stream.read_exact(&mut head)?;
            open.push((Some(stream), None));
        } else {
            let mut client = Client::new(port);
            let _status = client.status(&get("/livez"))?;
            open.push((None, Some(client)));
        }
    }
    let with_streams_mib = memory_mib(process, "VmRSS")?;
    drop(open);
    Ok(Memory {
        idle_mib,
        with_streams_mib,
        streams,
    })
}
