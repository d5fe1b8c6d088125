//! The two services of a port: the orders that the sensor publishes, and the readings that the program of another publishes.
//!
//! In: the name of a port. Out: both services, made or found, in a folder and under names of shared memory that belong to this
//! user alone and to no session of a cell. One program at a time may write readings: the next one is refused by iceoryx2
//! itself. What a killed program leaves behind is removed by whoever opens a port next.

use std::fs::{self, DirBuilder, File};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use mrroc::payload::layout_hash;
use mrroc_launch::cell_file::ExternalEntry;
use rustix::fs::OFlags;
use rustix::process::geteuid;
use rustix::time::{ClockId, clock_gettime};

use crate::message::Message;

/// The variable of the environment that names another folder for ports.
const FOLDER: &str = "MRROC_PORTS";

/// The folder of the segments of shared memory.
const SHARED_MEMORY: &str = "/dev/shm";

/// Programs that may look at the messages of a port besides those that it is for.
const SUBSCRIBERS: usize = 7;

/// Processes that may use a port at a time.
const NODES: usize = 2 + SUBSCRIBERS;

type Service = PortFactory<ipc::Service, Message, ()>;

/// This process's ends of a port.
pub(crate) struct Port {
    orders: Publisher<ipc::Service, Message, ()>,
    readings: Subscriber<ipc::Service, Message, ()>,
    node: Node<ipc::Service>,
}

/// Now, by the clock that all programs of this machine share: `CLOCK_MONOTONIC` \[ns\].
#[must_use]
pub fn monotonic() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    (now.tv_sec * 1_000_000_000 + now.tv_nsec).cast_unsigned()
}

/// The port of a sensor whose readings the bridge to ROS 2 sends: the file's `port`, or one of this cell alone. So no goal and no message that is meant for one cell
/// comes to another one whose sensor has the same name.
#[must_use]
pub fn port_of_cell(entry: &ExternalEntry) -> String {
    // A program on another machine calls at an address, of which there is one.
    if entry.has_port() || entry.address().is_some() {
        return entry.port().to_owned();
    }
    let file = entry.cell_file();
    // The cell and the bridge may name it from different folders; of a test there is none.
    let place = fs::canonicalize(file).or_else(|_| std::path::absolute(file));
    let place = place.unwrap_or_else(|_| file.to_owned());
    format!("{}-{:016x}", entry.name(), layout_hash(0, &place.to_string_lossy()))
}

impl Port {
    /// Opens the port of this name in a folder of ports.
    ///
    /// # Errors
    /// Why it cannot be opened, and what to do.
    pub fn open(folder: &Path, name: &str) -> Result<Port, String> {
        let Ends { node } = Ends::open(folder)?;
        let (orders, readings) = (service(&node, name, "orders")?, service(&node, name, "readings")?);
        let failed = |what: &str, error: String| format!("port `{name}`: {what}: {error}");
        Ok(Port {
            orders: orders.publisher_builder().create().map_err(|_| {
                format!("port `{name}`: another sensor reads it; give one of them another `port`")
            })?,
            readings: readings
                .subscriber_builder()
                .create()
                .map_err(|error| failed("too many programs look at it", error.to_string()))?,
            node,
        })
    }

    /// Publishes an order, for the program to take when it likes.
    pub fn order(&self, order: Message) {
        // Nobody may be there to take it, which is nobody's fault.
        let _ = self.orders.send_copy(order);
    }

    /// The newest message of the program since the last call.
    pub fn newest(&self) -> Option<Message> {
        // One is kept: a program that sends without end cannot keep the sensor busy.
        self.readings.receive().ok().flatten().map(|sample| *sample)
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        // A program that was killed has left its ends behind.
        self.node.try_cleanup_dead_nodes();
    }
}

/// The ends that a program has of a port; one program at a time has them.
pub(crate) struct ProgramEnds {
    readings: Publisher<ipc::Service, Message, ()>,
    orders: Subscriber<ipc::Service, Message, ()>,
    node: Node<ipc::Service>,
}

impl ProgramEnds {
    /// # Errors
    /// Another program sends what the sensor reads.
    pub fn open(node: Node<ipc::Service>, name: &str) -> Result<ProgramEnds, String> {
        let (orders, readings) = (service(&node, name, "orders")?, service(&node, name, "readings")?);
        let readings = readings.publisher_builder().create();
        let taken = "another program of this machine sends what the sensor reads\n help: end it";
        Ok(ProgramEnds {
            readings: readings.map_err(|_| format!("port `{name}`: {taken}"))?,
            orders: orders
                .subscriber_builder()
                .create()
                .map_err(|error| format!("port `{name}`: {error}"))?,
            node,
        })
    }

    /// Sends a reading.
    pub fn send(&self, reading: Message) {
        // Nobody may be there to take it, which is nobody's fault.
        let _ = self.readings.send_copy(reading);
    }

    /// The newest order since the last call.
    pub fn newest(&self) -> Option<Message> {
        self.orders.receive().ok().flatten().map(|sample| *sample)
    }
}

impl Drop for ProgramEnds {
    fn drop(&mut self) {
        self.node.try_cleanup_dead_nodes();
    }
}

/// What this process has of the ports of a folder.
pub(crate) struct Ends {
    pub node: Node<ipc::Service>,
}

impl Ends {
    /// # Errors
    /// The folder is not this user's alone, or nothing can be made in it.
    pub fn open(folder: &Path) -> Result<Ends, String> {
        make_private(folder)?;
        let prefix = prefix(folder);
        let node = node(folder, &prefix)?;
        close_to_others(&prefix)?;
        Ok(Ends { node })
    }
}

/// The folder of the ports of this user.
pub(crate) fn folder() -> PathBuf {
    let own = || PathBuf::from(format!("/tmp/mrroc-ports-{}", geteuid().as_raw()));
    std::env::var_os(FOLDER).filter(|folder| !folder.is_empty()).map_or_else(own, PathBuf::from)
}

/// The names of the segments of shared memory for the ports of a folder begin with this.
pub(crate) fn prefix(folder: &Path) -> String {
    format!("mrroc_ports_{:016x}_", layout_hash(0, &folder.to_string_lossy()))
}

/// Makes the folder, or makes sure that no other user can write to it.
fn make_private(folder: &Path) -> Result<(), String> {
    let failed = |error: io::Error| format!("the folder {} of ports: {error}", folder.display());
    match DirBuilder::new().mode(0o700).create(folder) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(failed(error)),
        Ok(()) | Err(_) => {}
    }
    let about = fs::symlink_metadata(folder).map_err(failed)?;
    if about.is_dir() && about.uid() == geteuid().as_raw() && about.mode() & 0o077 == 0 {
        return Ok(());
    }
    Err(format!(
        "the folder {} of ports is not this user's alone; name another one by {FOLDER}",
        folder.display()
    ))
}

pub(crate) fn node(folder: &Path, prefix: &str) -> Result<Node<ipc::Service>, String> {
    let failed = |error: &dyn core::fmt::Display| format!("the ports in {}: {error}", folder.display());
    set_log_level(LogLevel::Fatal);
    let mut config = Config::default();
    let path = iceoryx2::prelude::Path::new(folder.to_string_lossy().as_bytes());
    config.global.set_root_path(&path.map_err(|error| failed(&error))?);
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(|error| failed(&error))?;
    let node = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
    node.create::<ipc::Service>().map_err(|error| failed(&error))
}

/// The one segment that iceoryx2 lets all users write to, it does not let anybody but this user any more.
fn close_to_others(prefix: &str) -> Result<(), String> {
    for entry in fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
        let is_it = |name: &str| name.starts_with(prefix) && name.ends_with(".global_mgmt");
        if !entry.file_name().to_str().is_some_and(is_it) {
            continue;
        }
        let failed = |error: io::Error| format!("{}: {error}", entry.path().display());
        // Nothing is followed that is a link.
        let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed();
        let file = File::options().read(true).custom_flags(flags).open(entry.path()).map_err(failed)?;
        file.set_permissions(fs::Permissions::from_mode(0o600)).map_err(failed)?;
    }
    Ok(())
}

/// One direction of a sensor's port.
pub(crate) fn service(node: &Node<ipc::Service>, name: &str, direction: &str) -> Result<Service, String> {
    // One is kept: only the newest counts.
    channel(node, &format!("{name}/{direction}"), 1).map_err(|why| format!("port `{name}`: {why}"))
}

/// A service of this name below `mrroc`: one program writes it, and so many messages wait for who reads them.
pub(crate) fn channel<M: ZeroCopySend + core::fmt::Debug + 'static>(
    node: &Node<ipc::Service>,
    name: &str,
    kept: usize,
) -> Result<PortFactory<ipc::Service, M, ()>, String> {
    let service = ServiceName::new(&format!("mrroc/{name}")).map_err(|error| error.to_string())?;
    let service = node
        .service_builder(&service)
        .publish_subscribe::<M>()
        .max_publishers(1)
        .max_subscribers(1 + SUBSCRIBERS)
        .max_nodes(NODES)
        .history_size(0)
        .subscriber_max_buffer_size(kept)
        .enable_safe_overflow(true)
        .open_or_create()
        .map_err(|error| {
            format!("it has other messages or writers; end the program that made it ({error})")
        })?;
    if service.static_config().max_publishers() != 1 {
        return Err("it may have more than one writer; end the program that made it".to_owned());
    }
    Ok(service)
}

#[cfg(test)]
mod tests {
    use mrroc_launch::cell_file::CellFile;

    use super::*;

    #[test]
    fn sensors_of_one_name_in_two_cells_have_two_ports_unless_their_files_say_one() {
        let port = |file: &str, said: &str| {
            let text = format!(
                "step_ms = 2\nrobots.arm = {{ kind = \"irp6\", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }}\n[sensors.goals]\nmode = \"free running\"\nperiod_ms = 4\nstale_after_ms = 500\n\
                 [sensors.goals.external]\nrate_hz = 500.0\n{said}"
            );
            let file = CellFile::parse(file, &text).expect("its form is right");
            port_of_cell(file.external("goals").expect("it is there"))
        };
        assert_ne!(port("/a/cell.toml", ""), port("/b/cell.toml", ""));
        assert!(port("/a/cell.toml", "").starts_with("goals-"));
        assert_eq!(port("/a/cell.toml", "port = \"p\""), port("/b/cell.toml", "port = \"p\""));
        // One file by two names.
        let here = std::env::current_dir().expect("a folder").join("Cargo.toml");
        assert_eq!(port("Cargo.toml", ""), port(&here.to_string_lossy(), ""));
    }

    #[test]
    fn names_of_shared_memory_are_those_that_the_python_side_makes_of_the_folder() {
        // FNV-1a of the text, 64 bits, from its reference implementation.
        assert_eq!(prefix(Path::new("/tmp/p")), format!("mrroc_ports_{:016x}_", fnv1a(b"/tmp/p")));
    }

    /// As its authors define it.
    fn fnv1a(bytes: &[u8]) -> u64 {
        bytes.iter().fold(14_695_981_039_346_656_037, |hash, &byte| {
            (hash ^ u64::from(byte)).wrapping_mul(1_099_511_628_211)
        })
    }

    #[test]
    fn a_folder_that_others_may_write_to_is_refused() {
        let folder = std::env::temp_dir().join(format!("mrroc-ports-test-{}", std::process::id()));
        make_private(&folder).expect("a new folder");
        assert_eq!(fs::metadata(&folder).expect("there").mode() & 0o777, 0o700);
        make_private(&folder).expect("it is the user's own");
        fs::set_permissions(&folder, fs::Permissions::from_mode(0o770)).expect("set");
        let told = make_private(&folder).expect_err("others may write to it");
        assert!(told.contains("is not this user's alone"), "{told}");
        fs::remove_dir(&folder).expect("removed");
    }
}
