use std::fmt;
use std::future::Future;
use std::io;
use std::net::SocketAddr;
use std::str::FromStr;

use thiserror::Error;
use tokio::io::{AsyncRead, AsyncWrite};

/// Opens connections to controllers. The seam through which a test puts another network.
pub trait Connector: Send + Sync + 'static {
    /// An open connection.
    type Stream: AsyncRead + AsyncWrite + Send + Unpin + 'static;

    /// Connects. Dropping the future abandons the attempt.
    ///
    /// # Errors
    /// The connection was not made.
    fn connect(
        &self,
        address: &ControllerAddress,
    ) -> impl Future<Output = io::Result<Self::Stream>> + Send;

    /// Called once for every connection, before its first byte is written, with the request the bytes belong to.
    fn before_send(&self, stream: &Self::Stream, request_id: &str) {
        let _ = (stream, request_id);
    }
}

/// Where a controller's socket server listens.
#[derive(Clone, Debug, Eq, PartialEq)]
pub enum ControllerAddress {
    /// A numeric address.
    Numeric(SocketAddr),
    /// A host name, looked up for every connection.
    Named {
        /// The host.
        host: String,
        /// The port.
        port: u16,
    },
}

impl ControllerAddress {
    /// The same host, one port on; `None` after the last port.
    pub(crate) fn next_port(&self) -> Option<Self> {
        Some(match self {
            Self::Numeric(address) => {
                let port = address.port().checked_add(1)?;
                Self::Numeric(SocketAddr::new(address.ip(), port))
            }
            Self::Named { host, port } => Self::Named {
                host: host.clone(),
                port: port.checked_add(1)?,
            },
        })
    }
}

impl FromStr for ControllerAddress {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        let error = || AddressError {
            text: text.to_owned(),
        };
        if let Ok(address) = text.parse::<SocketAddr>() {
            return match address.port() {
                0 => Err(error()),
                _ => Ok(Self::Numeric(address)),
            };
        }
        let (host, port) = text.rsplit_once(':').ok_or_else(error)?;
        let port = port.parse().map_err(|_| error())?;
        let legal = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'.' || byte == b'-';
        if port == 0 || host.is_empty() || host.len() > 253 || !host.bytes().all(legal) {
            return Err(error());
        }
        Ok(Self::Named {
            host: host.to_owned(),
            port,
        })
    }
}

impl fmt::Display for ControllerAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Numeric(address) => write!(f, "{address}"),
            Self::Named { host, port } => write!(f, "{host}:{port}"),
        }
    }
}

/// A text that is not a controller's address.
#[derive(Clone, Debug, Eq, Error, PartialEq)]
#[error("`{text}` is not `host:port` with a port of 1 to 65535")]
pub struct AddressError {
    text: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_host_and_port() {
        for text in ["127.0.0.1:59002", "[::1]:59002", "robot-1.plant.example:1"] {
            let address: ControllerAddress = text.parse().unwrap();
            assert_eq!(address.to_string(), text);
        }
    }

    #[test]
    fn anything_else_is_refused() {
        for text in [
            "",
            "robot",
            "robot:",
            ":1",
            "robot:0",
            "127.0.0.1:0",
            "a b:1",
            "robot:65536",
            "http://robot:1",
        ] {
            let error = text.parse::<ControllerAddress>().unwrap_err();
            assert!(error.to_string().contains(text));
        }
    }
}
