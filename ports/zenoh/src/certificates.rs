//! Certificates of a cell: an authority of its own, and one certificate for each node, which bears the node's name. For a sensor
//! whose program is on another machine there are two: that of the program bears the name of the one sensor for which it may
//! speak, and opens nothing else; that of the sensor's gateway is on the sensor's machine.
//!
//! In: nodes and gateways with their addresses. Out: a folder with the authority's key, and a folder for each machine, to be
//! copied there. Keys are readable by their owner alone (0600). The authority's key is needed for nothing but further
//! certificates, and belongs on none of the machines.

use std::fs::{self, DirBuilder, OpenOptions};
use std::io::{self, Write};
use std::net::SocketAddr;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use mrroc_launch::network::CertificateRequest;
use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose,
};

/// The file of the authority's certificate, in the folder of each node.
const AUTHORITY: &str = "authority.pem";

/// The folder for the machine of a cell without nodes.
const CELL: &str = "cell";

/// The name in the certificate of a sensor's program. No node has it, because there is a dot in it.
pub(crate) fn program(sensor: &str) -> String {
    format!("sensor.{sensor}")
}

/// The name in the certificate of a sensor's gateway.
pub(crate) fn gateway(sensor: &str) -> String {
    format!("door.{sensor}")
}

/// The files of one node, or one gateway.
#[derive(Clone, Debug)]
pub(crate) struct Files {
    /// The certificate of the cell's authority.
    pub authority: PathBuf,
    /// The node's own certificate.
    pub certificate: PathBuf,
    /// The key to it.
    pub key: PathBuf,
}

impl Files {
    /// Those of the node or gateway `name`, in this folder; `copied` is what is to be copied to it, of the folder of certificates.
    ///
    /// # Errors
    /// One of them is not there, or others may read the key.
    pub fn of(name: &str, folder: &Path, copied: &str) -> Result<Files, String> {
        let files = Files {
            authority: folder.join(AUTHORITY),
            certificate: folder.join(format!("{name}.pem")),
            key: folder.join(format!("{name}.key")),
        };
        for file in [&files.authority, &files.certificate, &files.key] {
            if let Err(error) = fs::File::open(file) {
                return Err(format!(
                    "{name} has no {}: {error}\n help: make certificates: PROGRAM certificates FOLDER, and put what is in \
                     FOLDER/{copied} into {}",
                    file.display(),
                    folder.display()
                ));
            }
        }
        let about = fs::metadata(&files.key).map_err(|error| error.to_string())?;
        let mode = std::os::unix::fs::PermissionsExt::mode(&about.permissions()) & 0o777;
        if mode & 0o077 != 0 {
            let key = files.key.display();
            return Err(format!("others may read {key}: its mode is {mode:o}\n help: chmod 600 {key}"));
        }
        Ok(files)
    }
}

/// Makes the certificates of these nodes and gateways; returns what was made.
///
/// # Errors
/// The folder has files already, or cannot be written.
pub(crate) fn make(whom: &CertificateRequest<'_>, folder: &Path) -> io::Result<String> {
    if folder.is_dir() && fs::read_dir(folder)?.next().is_some() {
        return Err(io::Error::other("has files already\n help: give a folder that is empty or not there"));
    }
    private_folder(folder)?;
    let mut params = CertificateParams::default();
    params.distinguished_name.push(DnType::CommonName, "the authority of a cell of mrroc");
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    let key = KeyPair::generate().map_err(io::Error::other)?;
    let authority = params.self_signed(&key).map_err(io::Error::other)?.pem();
    write(&folder.join("authority.key"), &key.serialize_pem())?;
    write(&folder.join(AUTHORITY), &authority)?;
    let issuer = Issuer::new(params, key);
    let certify = |own: &Path, name: &str, address: Option<SocketAddr>| -> io::Result<()> {
        // Whoever calls compares the address; who is called, and the rules of access, the name.
        let names = address.map(|address| address.ip().to_string()).into_iter().chain([name.to_owned()]);
        let mut params = CertificateParams::new(names.collect::<Vec<_>>()).map_err(io::Error::other)?;
        params.distinguished_name = rcgen::DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, name);
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ClientAuth];
        if address.is_some() {
            params.extended_key_usages.push(ExtendedKeyUsagePurpose::ServerAuth);
        }
        params.use_authority_key_identifier_extension = true;
        let key = KeyPair::generate().map_err(io::Error::other)?;
        let certificate = params.signed_by(&key, &issuer).map_err(io::Error::other)?;
        write(&own.join(format!("{name}.pem")), &certificate.pem())?;
        write(&own.join(format!("{name}.key")), &key.serialize_pem())
    };
    let begin = |own: &Path| {
        private_folder(own)?;
        write(&own.join(AUTHORITY), &authority)
    };
    let mut told = String::new();
    for node in whom.nodes {
        let name = node.name.as_str();
        let own = folder.join(name);
        begin(&own)?;
        certify(&own, name, Some(node.address))?;
        told += &format!(
            "{}: copy it to node {name}, as the folder `certificates` beside its cell.toml\n",
            own.display()
        );
    }
    for &(sensor, address, node) in &whom.gateways {
        let own = folder.join(node.unwrap_or(CELL));
        if !own.is_dir() {
            begin(&own)?;
            told += &format!(
                "{}: copy it to the machine of the cell, as the folder `certificates` beside its cell.toml\n",
                own.display()
            );
        }
        certify(&own, &gateway(sensor), Some(address))?;
        let own = folder.join(program(sensor));
        begin(&own)?;
        certify(&own, &program(sensor), None)?;
        told += &format!(
            "{}: copy it to the machine of the program of sensor {sensor}, as the folder `certificates` beside {sensor}_port.py\n",
            own.display()
        );
    }
    told += &format!(
        "{}: makes further certificates; keep it on none of these machines\n",
        folder.join("authority.key").display()
    );
    Ok(told)
}

fn private_folder(folder: &Path) -> io::Result<()> {
    DirBuilder::new().recursive(true).mode(0o700).create(folder)
}

fn write(file: &Path, text: &str) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(file)?;
    file.write_all(text.as_bytes())
}
