//! What keeps a panel's connections secret on a network: TLS, with the feature `network`.
//!
//! In: the address at which the panel answers, and the folder `certificates` beside the cell's file. Out: a certificate whose
//! fingerprint a person compares, and connections that nobody else reads or changes.
//!
//! ```text
//! certificates/panel.pem, panel.key    those, if they are there: of an authority that the browser trusts
//! neither                              a certificate that signs itself, a new one at each start; its key is never written down
//! ```

use std::io;
use std::net::IpAddr;
use std::path::Path;

use tokio::net::TcpStream;

#[cfg(feature = "network")]
pub use with::Secured;
#[cfg(not(feature = "network"))]
pub use without::Secured;

#[cfg(not(feature = "network"))]
mod without {
    use super::{IpAddr, Path, TcpStream, io};

    /// Nothing: this program was built without it.
    #[derive(Clone)]
    pub enum Secured {}

    impl Secured {
        /// # Errors
        /// Always: with what to do.
        pub fn at(_: IpAddr, _: Option<&Path>) -> io::Result<Secured> {
            Err(io::Error::other(
                "this program was built without what secures a panel on a network\n help: build it with mrroc's feature \
                 `panel-network`, or leave out MRROC_PANEL_ADDRESS and use ssh -L",
            ))
        }

        pub fn fingerprint(&self) -> &str {
            match *self {}
        }

        pub async fn accept(&self, _: TcpStream) -> io::Result<TcpStream> {
            match *self {}
        }
    }
}

#[cfg(feature = "network")]
mod with {
    use std::fmt::Write as _;
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    use std::sync::Arc;

    use rcgen::{CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, KeyPair};
    use tokio_rustls::TlsAcceptor;
    use tokio_rustls::rustls::crypto::ring::default_provider;
    use tokio_rustls::rustls::pki_types::pem::PemObject;
    use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer};
    use tokio_rustls::rustls::{ServerConfig, version};
    use tokio_rustls::server::TlsStream;

    use super::{IpAddr, Path, TcpStream, io};

    /// A certificate, and what answers with it.
    #[derive(Clone)]
    pub struct Secured {
        acceptor: TlsAcceptor,
        fingerprint: Arc<str>,
    }

    impl Secured {
        /// At this address, with the certificate of a folder if it has one.
        ///
        /// # Errors
        /// The files cannot be read, do not belong together, or others may read the key.
        pub fn at(address: IpAddr, folder: Option<&Path>) -> io::Result<Secured> {
            let (chain, key) = match folder.map(read).transpose()?.flatten() {
                Some(own) => own,
                None => signed_by_itself(address).map_err(io::Error::other)?,
            };
            // The fingerprint is that of the panel's own certificate, which comes first.
            let own =
                chain.first().ok_or_else(|| io::Error::other("certificates/panel.pem has no certificate"))?;
            let digest = ring::digest::digest(&ring::digest::SHA256, own);
            let mut fingerprint = String::new();
            for (place, byte) in digest.as_ref().iter().enumerate() {
                let between = if place == 0 { "" } else { ":" };
                let _ = write!(fingerprint, "{between}{byte:02X}");
            }
            let config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
                .with_protocol_versions(&[&version::TLS13])
                .and_then(|config| config.with_no_client_auth().with_single_cert(chain, key))
                .map_err(|why| io::Error::other(format!("the panel's certificate cannot be used: {why}")))?;
            Ok(Secured { acceptor: TlsAcceptor::from(Arc::new(config)), fingerprint: fingerprint.into() })
        }

        /// SHA-256 of the certificate, as browsers show it.
        pub fn fingerprint(&self) -> &str {
            &self.fingerprint
        }

        /// Agrees on keys with a browser.
        ///
        /// # Errors
        /// It does not speak TLS 1.3, or goes away.
        pub async fn accept(&self, stream: TcpStream) -> io::Result<TlsStream<TcpStream>> {
            self.acceptor.accept(stream).await
        }
    }

    type Certified = (Vec<CertificateDer<'static>>, PrivateKeyDer<'static>);

    /// What is in the folder; `None` if it has no certificate of a panel.
    fn read(folder: &Path) -> io::Result<Option<Certified>> {
        let (certificate, key) = (folder.join("panel.pem"), folder.join("panel.key"));
        let bad = |file: &Path, why: &dyn core::fmt::Display| {
            io::Error::new(io::ErrorKind::InvalidData, format!("{}: {why}", file.display()))
        };
        let is_there = |file: &Path| file.try_exists().map_err(|why| bad(file, &why));
        match (is_there(&certificate)?, is_there(&key)?) {
            (true, true) => {}
            (false, false) => return Ok(None),
            (true, false) => return Err(bad(&key, &"there is a certificate, and no key to it")),
            (false, true) => return Err(bad(&certificate, &"there is a key, and no certificate to it")),
        }
        let mode = fs::metadata(&key).map_err(|why| bad(&key, &why))?.permissions().mode() & 0o777;
        if mode & 0o077 != 0 {
            let help =
                format!("others may read it: its mode is {mode:o}\n help: chmod 600 {}", key.display());
            return Err(bad(&key, &help));
        }
        let chain = CertificateDer::pem_file_iter(&certificate).and_then(Iterator::collect);
        let chain = chain.map_err(|why| bad(&certificate, &why))?;
        let secret = PrivateKeyDer::from_pem_file(&key).map_err(|why| bad(&key, &why))?;
        Ok(Some((chain, secret)))
    }

    fn signed_by_itself(address: IpAddr) -> Result<Certified, rcgen::Error> {
        let mut params = CertificateParams::new(vec![address.to_string()])?;
        params.distinguished_name = DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, "the panel of a cell of mrroc");
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
        let key = KeyPair::generate()?;
        let certificate = params.self_signed(&key)?;
        let key = PrivatePkcs8KeyDer::from(key.serialize_der());
        Ok((vec![certificate.der().clone()], key.into()))
    }
}
