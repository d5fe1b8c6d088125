//! The origins that are admitted: which requests come from a page of this panel.
//!
//! In: the headers `Host` and `Origin`. Out: whether the request is answered. A page of another site cannot connect, because its
//! origin is another one; a name of another site that is made to lead to this machine is no host of this panel.

use std::net::SocketAddr;

/// The hosts by which this panel is called, and how its pages are reached.
#[derive(Clone, Debug)]
pub struct OriginPolicy {
    hosts: Vec<String>,
    scheme: &'static str,
}

/// Why a request is not answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotAdmitted {
    /// It calls this machine by another name.
    #[error("this is no host of the panel: open the address that it has printed")]
    Host,
    /// It comes from a page of another origin, or does not say from which.
    #[error("only pages of the panel itself connect to it")]
    Origin,
}

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestTarget {
    /// A file of the page.
    File,
    /// A connection that shows and operates the cell.
    Connection,
}

impl OriginPolicy {
    /// Of a panel at this address: of the loopback interface, by any of its names; or of a network, by that address alone and with TLS.
    #[must_use]
    pub fn at(address: SocketAddr) -> OriginPolicy {
        let port = address.port();
        if address.ip().is_loopback() {
            let mut hosts: Vec<_> =
                ["127.0.0.1", "localhost", "[::1]"].map(|name| format!("{name}:{port}")).into();
            // Loopback has more addresses than these.
            if !hosts.contains(&address.to_string()) {
                hosts.push(address.to_string());
            }
            return OriginPolicy { hosts, scheme: "http://" };
        }
        let mut hosts = vec![address.to_string()];
        if port == 443 {
            // What browsers leave out.
            hosts.extend(address.to_string().strip_suffix(":443").map(str::to_owned));
        }
        OriginPolicy { hosts, scheme: "https://" }
    }

    /// How its pages are reached: `http://`, or `https://` on a network.
    #[must_use]
    pub const fn scheme(&self) -> &'static str {
        self.scheme
    }

    /// Admits a request with these headers.
    ///
    /// # Errors
    /// [`NotAdmitted`]
    pub fn admit(
        &self,
        target: RequestTarget,
        host: Option<&str>,
        origin: Option<&str>,
    ) -> Result<(), NotAdmitted> {
        let host = host.filter(|host| self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host)));
        let host = host.ok_or(NotAdmitted::Host)?;
        match (origin, target) {
            // Browsers say the origin of every connection that a page opens, but not of a file that is only read.
            (None, RequestTarget::File) => Ok(()),
            (None, RequestTarget::Connection) => Err(NotAdmitted::Origin),
            (Some(origin), _) => {
                let own = origin.strip_prefix(self.scheme).is_some_and(|of| of.eq_ignore_ascii_case(host));
                if own { Ok(()) } else { Err(NotAdmitted::Origin) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_201_a_page_of_another_origin_or_a_host_of_another_name_is_not_admitted() {
        let origins = OriginPolicy::at(SocketAddr::from(([127, 0, 0, 1], 7411)));
        let connection =
            |host: Option<&str>, origin: Option<&str>| origins.admit(RequestTarget::Connection, host, origin);
        for host in ["127.0.0.1:7411", "localhost:7411", "[::1]:7411", "LocalHost:7411"] {
            let origin = format!("http://{host}");
            assert_eq!(connection(Some(host), Some(&origin)), Ok(()), "{host}");
            assert_eq!(origins.admit(RequestTarget::File, Some(host), None), Ok(()), "{host}");
        }
        let own = Some("127.0.0.1:7411");
        for origin in [
            "http://evil.example",
            "https://127.0.0.1:7411",
            "http://127.0.0.1:7412",
            "http://127.0.0.1",
            "http://127.0.0.1:7411.evil.example",
            "http://localhost:7411",
            "null",
            "",
        ] {
            assert_eq!(connection(own, Some(origin)), Err(NotAdmitted::Origin), "{origin}");
            assert_eq!(
                origins.admit(RequestTarget::File, own, Some(origin)),
                Err(NotAdmitted::Origin),
                "{origin}"
            );
        }
        assert_eq!(connection(own, None), Err(NotAdmitted::Origin));
        // A name that was made to lead here, the right name of another port, and none.
        for host in [Some("evil.example:7411"), Some("127.0.0.1:80"), Some("127.0.0.1"), Some(""), None] {
            assert_eq!(connection(host, Some("http://127.0.0.1:7411")), Err(NotAdmitted::Host), "{host:?}");
            assert_eq!(origins.admit(RequestTarget::File, host, None), Err(NotAdmitted::Host), "{host:?}");
        }
    }

    #[test]
    fn fault_201_on_a_network_a_panel_is_called_by_its_own_address_alone_and_never_without_tls() {
        let origins = OriginPolicy::at(SocketAddr::from(([192, 0, 2, 1], 7411)));
        let own = Some("192.0.2.1:7411");
        assert_eq!(origins.admit(RequestTarget::Connection, own, Some("https://192.0.2.1:7411")), Ok(()));
        assert_eq!(origins.admit(RequestTarget::File, own, None), Ok(()));
        for origin in ["http://192.0.2.1:7411", "https://192.0.2.2:7411", "https://192.0.2.1", "null"] {
            assert_eq!(
                origins.admit(RequestTarget::Connection, own, Some(origin)),
                Err(NotAdmitted::Origin),
                "{origin}"
            );
        }
        let second = OriginPolicy::at(SocketAddr::from(([127, 0, 0, 2], 7411)));
        assert_eq!(second.admit(RequestTarget::File, Some("127.0.0.2:7411"), None), Ok(()));
        // Names that lead to loopback, and any other name.
        for host in ["127.0.0.1:7411", "localhost:7411", "cell.example:7411", "192.0.2.1"] {
            let origin = format!("https://{host}");
            assert_eq!(
                origins.admit(RequestTarget::Connection, Some(host), Some(&origin)),
                Err(NotAdmitted::Host),
                "{host}"
            );
        }
        // The port of https is not said.
        let origins = OriginPolicy::at(SocketAddr::from(([192, 0, 2, 1], 443)));
        assert_eq!(
            origins.admit(RequestTarget::Connection, Some("192.0.2.1"), Some("https://192.0.2.1")),
            Ok(())
        );
    }
}
