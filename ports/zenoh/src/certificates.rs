//! Certificates of a cell: an authority of its own, and one certificate for each node, which bears the node's name.
//!
//! In: nodes with their addresses. Out: a folder with the authority's key, and a folder for each node, to be copied to the
//! node's machine. Keys are readable by their owner alone (0600). The authority's key is needed for nothing but further
//! certificates, and belongs on none of the machines.

use std::fs::{self, DirBuilder, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use mrroc_core::cell::Node;
use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose,
};

/// The file of the authority's certificate, in the folder of each node.
const AUTHORITY: &str = "authority.pem";

/// The files of one node.
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
    /// Those of the node `name`, in this folder.
    ///
    /// # Errors
    /// One of them is not there, or others may read the key.
    pub fn of(name: &str, folder: &Path) -> Result<Files, String> {
        let files = Files {
            authority: folder.join(AUTHORITY),
            certificate: folder.join(format!("{name}.pem")),
            key: folder.join(format!("{name}.key")),
        };
        for file in [&files.authority, &files.certificate, &files.key] {
            if let Err(error) = fs::File::open(file) {
                return Err(format!(
                    "node {name} has no {}: {error}\n help: make certificates: PROGRAM certificates FOLDER, and put what is in \
                     FOLDER/{name} into {}",
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

/// Makes the certificates of these nodes; returns what was made.
///
/// # Errors
/// The folder has files already, or cannot be written.
pub(crate) fn make(nodes: &[Node], folder: &Path) -> io::Result<String> {
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
    let mut told = String::new();
    for node in nodes {
        let name = node.name.as_str();
        let own = folder.join(name);
        private_folder(&own)?;
        // Whoever calls the node compares the address; who is called, and the rules of access, the name.
        let mut params = CertificateParams::new(vec![node.address.ip().to_string(), name.to_owned()])
            .map_err(io::Error::other)?;
        params.distinguished_name = rcgen::DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, name);
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages =
            vec![ExtendedKeyUsagePurpose::ServerAuth, ExtendedKeyUsagePurpose::ClientAuth];
        params.use_authority_key_identifier_extension = true;
        let key = KeyPair::generate().map_err(io::Error::other)?;
        let certificate = params.signed_by(&key, &issuer).map_err(io::Error::other)?;
        write(&own.join(AUTHORITY), &authority)?;
        write(&own.join(format!("{name}.pem")), &certificate.pem())?;
        write(&own.join(format!("{name}.key")), &key.serialize_pem())?;
        told += &format!(
            "{}: copy it to node {name}, as the folder `certificates` beside its cell.toml\n",
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
