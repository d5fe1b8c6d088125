//! What a cell is to the machine, whatever path leads to its file, whoever starts it and wherever its sessions are: its
//! file, and the hardware that its drivers name.
//!
//! In: the path of a cell's file, names of hardware. Out: names of abstract sockets, which every process in the same network
//! namespace sees, and which vanish with the process that has bound them. A launcher binds the name of its cell and those
//! of its hardware; nobody else can bind them meanwhile. Beside each it binds a name that says who it is, for whom a name is
//! taken. No such socket takes a connection, but for that of the console server.

use std::fs::{self, Metadata};
use std::io::{self, ErrorKind};
use std::os::fd::OwnedFd;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::fs::MetadataExt;
use std::os::unix::net::{SocketAddr, UnixDatagram, UnixListener};
use std::path::Path;
use std::time::Duration;

use mrroc_core::payload::layout_hash;

/// Where the system lists all sockets.
const LIST: &str = "/proc/net/unix";

/// How often a launcher looks for the process that has taken a name before it gives up: that process binds the name first,
/// and then says who it is.
const LOOKS: u32 = 50;
const LOOK: Duration = Duration::from_millis(10);

/// A cell, by the identity of its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CellId(pub u64);

impl CellId {
    /// The cell of a file: the same for every path that leads to the file. Where there is no file, the path is the cell.
    pub fn of(cell: &Path) -> CellId {
        let file = |file: Metadata| format!("file {} {}", file.dev(), file.ino());
        let what = fs::metadata(cell).map_or_else(|_| format!("path {}", cell.display()), file);
        CellId(layout_hash(0, &what))
    }

    fn name(self) -> String {
        format!("mrroc-cell-{:016x}", self.0)
    }

    /// The launcher that runs the cell, if one does.
    pub fn holder(self) -> Option<Holder> {
        holder(&self.name())
    }

    /// Whether processes of the cell exist, besides its launcher.
    pub fn has_parts(self) -> bool {
        let part = format!("{}-part-", self.name());
        names().iter().any(|name| name.starts_with(&part))
    }

    /// The abstract name of the cell's console server.
    pub fn console(self) -> String {
        format!("{}-console", self.name())
    }
}

/// Marks this process as one of a cell as long as it lives.
///
/// # Errors
/// The socket cannot be made.
pub(crate) fn take_part(cell: CellId) -> io::Result<OwnedFd> {
    bind(&format!("{}-part-{}", cell.name(), std::process::id()))
}

/// The process that has taken a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Holder {
    /// The number of the process.
    pub pid: u32,
    /// The number of its user.
    pub user: u32,
}

impl Holder {
    /// Whether it belongs to this user.
    pub fn is_ours(self) -> bool {
        self.user == rustix::process::getuid().as_raw()
    }
}

/// A name that another process has taken; with what is known of that process.
#[derive(Debug)]
pub(crate) enum AlreadyTaken {
    /// The cell's.
    Cell(Option<Holder>),
    /// That of its hardware.
    Hardware(String, Option<Holder>),
    /// A socket could not be made.
    Io(io::Error),
}

/// The names that a launcher has taken, as long as it lives.
#[derive(Debug)]
pub(crate) struct Names(Vec<OwnedFd>);

impl Names {
    /// Takes the names of a cell and of its hardware.
    ///
    /// # Errors
    /// [`AlreadyTaken`]: another process has one of them.
    pub fn take(cell: CellId, hardware: &[String]) -> Result<Names, AlreadyTaken> {
        let mut names = Names(Vec::new());
        names.bind(&cell.name(), AlreadyTaken::Cell)?;
        for what in hardware {
            let name = format!("mrroc-hardware-{:016x}", layout_hash(0, what));
            names.bind(&name, |holder| AlreadyTaken::Hardware(what.clone(), holder))?;
        }
        Ok(names)
    }

    fn bind(
        &mut self,
        name: &str,
        taken: impl FnOnce(Option<Holder>) -> AlreadyTaken,
    ) -> Result<(), AlreadyTaken> {
        match bind(name) {
            Ok(socket) => self.0.push(socket),
            Err(error) if error.kind() == ErrorKind::AddrInUse => {
                let found = (0..LOOKS).find_map(|look| {
                    if look > 0 {
                        std::thread::sleep(LOOK);
                    }
                    holder(name)
                });
                return Err(taken(found));
            }
            Err(error) => return Err(AlreadyTaken::Io(error)),
        }
        let user = rustix::process::getuid().as_raw();
        let own = format!("{name}-by-{}-{user}", std::process::id());
        self.0.push(bind(&own).map_err(AlreadyTaken::Io)?);
        Ok(())
    }
}

/// Makes the listener of a cell's console server.
///
/// # Errors
/// The name is taken, or the socket cannot be made.
pub(crate) fn listen(cell: CellId) -> io::Result<UnixListener> {
    UnixListener::bind_addr(&address(&cell.console())?)
}

fn address(name: &str) -> io::Result<SocketAddr> {
    SocketAddr::from_abstract_name(name)
}

/// Binds a name; nothing is received there.
fn bind(name: &str) -> io::Result<OwnedFd> {
    UnixDatagram::bind_addr(&address(name)?).map(OwnedFd::from)
}

/// Who has taken a name, as that process says it.
fn holder(name: &str) -> Option<Holder> {
    let prefix = format!("{name}-by-");
    names().iter().find_map(|bound| {
        let (pid, user) = bound.strip_prefix(&prefix)?.split_once('-')?;
        Some(Holder { pid: pid.parse().ok()?, user: user.parse().ok()? })
    })
}

/// The abstract names of this program that are bound.
fn names() -> Vec<String> {
    let list = fs::read(LIST).unwrap_or_default();
    let names = list.split(|&byte| byte == b'\n').filter_map(|line| {
        let line = core::str::from_utf8(line).ok()?;
        line.rsplit_once(" @").map(|(_, name)| name).filter(|name| name.starts_with("mrroc-"))
    });
    names.map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_taken_once_and_says_who_has_it_until_its_holder_is_gone() {
        let folder = std::env::temp_dir().join(format!("mrroc-identity-{}", std::process::id()));
        fs::create_dir(&folder).expect("a folder");
        let (file, link, symbolic, copy) =
            (folder.join("a"), folder.join("b"), folder.join("c"), folder.join("d"));
        fs::write(&file, "").expect("written");
        fs::hard_link(&file, &link).expect("linked");
        std::os::unix::fs::symlink(&file, &symbolic).expect("linked");
        fs::copy(&file, &copy).expect("copied");
        let cell = CellId::of(&file);
        assert!([&link, &symbolic].into_iter().all(|path| CellId::of(path) == cell));
        assert_ne!(CellId::of(&copy), cell);
        assert_eq!(cell.holder(), None);

        let own = Holder { pid: std::process::id(), user: rustix::process::getuid().as_raw() };
        let drives = [format!("drives of test {}", own.pid)];
        let names = Names::take(cell, &drives).expect("free");
        assert_eq!(cell.holder(), Some(own));
        assert!(matches!(Names::take(cell, &[]), Err(AlreadyTaken::Cell(Some(holder))) if holder == own));
        let other = Names::take(CellId::of(&copy), &drives);
        assert!(
            matches!(other, Err(AlreadyTaken::Hardware(what, Some(holder))) if what == drives[0] && holder == own)
        );
        // Who could not take all took none.
        assert_eq!(CellId::of(&copy).holder(), None);
        drop(names);
        assert_eq!(cell.holder(), None);
        let part = take_part(cell).expect("free");
        assert!(cell.has_parts() && !CellId::of(&copy).has_parts());
        drop(part);
        assert!(!cell.has_parts() && Names::take(cell, &drives).is_ok());
        fs::remove_dir_all(&folder).expect("removed");
    }
}
