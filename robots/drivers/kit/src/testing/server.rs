//! A device on a socket, in real time.

#![expect(clippy::disallowed_methods, reason = "a device in real time")]

use core::time::Duration;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use super::device::{Device, Reply};

/// The longest time between two polls of a device.
const PAUSE: Duration = Duration::from_millis(1);

/// A device that listens at an address of this machine, in a thread that lives as long as the program. It takes one connection after
/// another.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
}

impl Server {
    /// Listens at an address, of which port 0 is any.
    ///
    /// # Errors
    /// There is no such address, or its port is taken; or a thread cannot be started.
    pub fn start<D: Device>(address: SocketAddr, device: Arc<Mutex<D>>) -> io::Result<Server> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let began = Instant::now();
        std::thread::Builder::new().name("device".to_owned()).spawn(move || {
            for socket in listener.incoming() {
                device.lock().unwrap_or_else(PoisonError::into_inner).connected();
                // The other end hangs up when it likes.
                drop(socket.and_then(|socket| serve(socket, began, &device)));
            }
        })?;
        Ok(Server { address })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

fn serve<D: Device>(mut socket: TcpStream, began: Instant, device: &Mutex<D>) -> io::Result<()> {
    socket.set_nodelay(true)?;
    socket.set_read_timeout(Some(PAUSE))?;
    let states = UdpSocket::bind((socket.local_addr()?.ip(), 0))?;
    let there = socket.peer_addr()?.ip();
    let mut bytes = [0; 1024];
    loop {
        let len = match socket.read(&mut bytes) {
            Ok(0) => return Ok(()),
            Ok(len) => len,
            Err(why) if matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(why) => return Err(why),
        };
        let mut reply = Reply::default();
        let mut model = device.lock().unwrap_or_else(PoisonError::into_inner);
        model.poll(began.elapsed(), &bytes[..len], &mut reply);
        drop(model);
        // In pieces, as TCP may bring it.
        reply.bytes.chunks(5).try_for_each(|piece| socket.write_all(piece))?;
        for (port, datagram) in &reply.datagrams {
            // The other end may have gone.
            let _ = states.send_to(datagram, (there, *port));
        }
        if reply.closes {
            return Ok(());
        }
    }
}

/// An address of this machine at which nobody listens.
///
/// # Errors
/// This machine has no port left.
pub fn unused_address() -> io::Result<SocketAddr> {
    TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr())
}
