//! 10,000 connections, each opened, used and closed: as many files are open afterwards as before.

use std::net::{Ipv4Addr, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Result, ensure};

use crate::client::{Client, get};
use crate::probe::open_files;

const CONNECTIONS: usize = 10_000;

/// Files open before and after.
pub(crate) fn measure(port: u16, process: u32) -> Result<(usize, usize)> {
    let before = settled(process, usize::MAX)?;
    for number in 0..CONNECTIONS {
        if number % 2 == 0 {
            let status = Client::new(port).status(&get("/livez"))?;
            ensure!(status == 200, "answered {status}");
        } else {
            drop(TcpStream::connect((Ipv4Addr::LOCALHOST, port))?);
        }
    }
    Ok((before, settled(process, before)?))
}

/// How many are open once they are `wanted`, or once that has been waited for.
fn settled(process: u32, wanted: usize) -> Result<usize> {
    let until = Instant::now() + Duration::from_secs(3);
    loop {
        let open = open_files(process)?;
        if open <= wanted && wanted != usize::MAX || Instant::now() >= until {
            return Ok(open);
        }
        thread::park_timeout(Duration::from_millis(20));
    }
}
