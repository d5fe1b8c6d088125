//! Messages of a topic as bytes, and who publishes what.
//!
//! In: a topic of DDS. Out: bodies of messages with their byte order, publisher and age. `ros2-client` decodes messages to types that are known when the program is
//! built, so its participant is asked itself.

use core::convert::Infallible;

use ros2_client::dds::rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SimpleDataReader};
use ros2_client::dds::rustdds::qos::policy;
use ros2_client::dds::rustdds::{
    DomainParticipant, GUID, QosPolicies, RepresentationIdentifier, Timestamp, TopicKind,
};
use ros2_client::{MessageTypeName, QosProfile};

use super::cdr::ByteOrder;

/// The longest body that is looked at \[bytes\].
pub const LONGEST: usize = 1 << 20;

/// Why a body of so many bytes is refused.
pub fn too_long(bytes: usize) -> String {
    format!("it has {bytes} bytes, more than 1 MiB")
}

/// A message.
#[derive(Clone, Debug)]
pub struct Body {
    content: Content,
    /// Who has published it.
    pub writer: GUID,
    /// How long it has waited since it came \[ns\].
    pub waited: u64,
}

impl Body {
    /// The order of its bytes.
    ///
    /// # Errors
    /// It is too long, or not in plain CDR.
    pub fn order(&self) -> Result<ByteOrder, String> {
        if self.content.len > LONGEST {
            return Err(too_long(self.content.len));
        }
        match self.content.encoding {
            RepresentationIdentifier::CDR_LE => Ok(ByteOrder::Little),
            RepresentationIdentifier::CDR_BE => Ok(ByteOrder::Big),
            other => Err(format!("it is not in plain CDR: {other:?}")),
        }
    }

    /// Its bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.content.bytes
    }
}

/// What is kept of a message that has come.
#[derive(Clone, Debug)]
struct Content {
    encoding: RepresentationIdentifier,
    len: usize,
    /// As many as are looked at.
    bytes: Vec<u8>,
}

/// A reader of such messages.
pub struct BodyReader(SimpleDataReader<Content, Undecoded>);

impl BodyReader {
    /// # Errors
    /// Why there is none.
    pub fn open(
        participant: &DomainParticipant,
        topic: &str,
        message: &MessageTypeName,
        qos: &QosProfile,
    ) -> Result<BodyReader, String> {
        let qos = QosPolicies::from(qos);
        let failed = |error: &dyn core::fmt::Display| error.to_string();
        let topic = participant
            .create_topic(dds_name(topic), message.dds_msg_type(), &qos, TopicKind::NoKey)
            .map_err(|error| failed(&error))?;
        let subscriber = participant.create_subscriber(&qos).map_err(|error| failed(&error))?;
        let reader = subscriber.create_simple_datareader_no_key(&topic, Some(qos));
        reader.map(BodyReader).map_err(|error| failed(&error))
    }

    /// The next message, if there is one.
    ///
    /// # Errors
    /// What came is none.
    pub fn next(&self) -> Result<Option<Body>, String> {
        self.0.drain_read_notifications();
        let Some(change) = self.0.try_take_one().map_err(|error| error.to_string())? else { return Ok(None) };
        // In units of 2^-32 s; a clock that was set back makes nothing younger than that it comes now.
        let ticks = Timestamp::now().to_ticks().saturating_sub(change.receive_instant.to_ticks());
        let waited = ((u128::from(ticks) * 1_000_000_000) >> 32) as u64;
        Ok(Some(Body { writer: change.writer_guid, waited, content: change.into_value() }))
    }
}

/// The name of a type as ROS 2 has it, of that which DDS has.
pub fn ros_name(dds: &str) -> String {
    let name = dds.strip_suffix('_').unwrap_or(dds);
    name.replace("::dds_::", "/").replace("::", "/")
}

/// Leaves a message as it is.
struct Undecoded;

impl DeserializerAdapter<Content> for Undecoded {
    type Error = Infallible;
    type Decoded = Content;

    /// All: what cannot be read is refused by name.
    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        use RepresentationIdentifier as Id;
        &[
            Id::CDR_LE,
            Id::CDR_BE,
            Id::PL_CDR_LE,
            Id::PL_CDR_BE,
            Id::XCDR2_LE,
            Id::XCDR2_BE,
            Id::CDR2_LE,
            Id::CDR2_BE,
            Id::D_CDR_LE,
            Id::D_CDR_BE,
            Id::XML,
        ]
    }

    fn transform_decoded(decoded: Content) -> Content {
        decoded
    }
}

impl DefaultDecoder<Content> for Undecoded {
    type Decoder = Keep;
    const DECODER: Keep = Keep;
}

#[derive(Clone)]
struct Keep;

impl Decode<'_, Content> for Keep {
    type Error = Infallible;

    fn decode_bytes(self, bytes: &[u8], encoding: RepresentationIdentifier) -> Result<Content, Infallible> {
        let kept = bytes.get(..LONGEST).unwrap_or(bytes);
        Ok(Content { encoding, len: bytes.len(), bytes: kept.to_vec() })
    }
}

/// A publisher.
#[derive(Clone, Debug)]
pub struct Writer {
    pub guid: GUID,
    /// The topic's name in DDS.
    pub topic: String,
    /// The type's name in DDS.
    pub message: String,
    reliable: bool,
    transient_local: bool,
}

impl Writer {
    /// Why a subscriber to this type that asks for this quality of service does not hear it.
    pub fn is_unheard_by(&self, message: &MessageTypeName, asked: &QosProfile) -> Option<String> {
        use ros2_client::qos::{Durability, Reliability};
        let expected = message.dds_msg_type();
        if self.message != expected {
            let [published, expected] = [&self.message, &expected].map(|name| ros_name(name));
            return Some(format!("it publishes {published}, not {expected}"));
        }
        if matches!(asked.reliability, Reliability::Reliable { .. }) && !self.reliable {
            let help = "leave `reliability` out in cell.toml, or make it reliable";
            return Some(format!("it is best effort\n help: {help}"));
        }
        if asked.durability == Durability::TransientLocal && !self.transient_local {
            let help = "leave `durability` out in cell.toml, or make it transient local";
            return Some(format!("it is volatile\n help: {help}"));
        }
        None
    }
}

/// The publishers that are known of other participants.
pub fn writers(participant: &DomainParticipant) -> Vec<Writer> {
    let of = participant.discovered_writers().into_iter();
    of.map(|writer| {
        let data = writer.publication_topic_data;
        Writer {
            guid: writer.writer_proxy.remote_writer_guid,
            // What is not said is the default of a writer of DDS.
            reliable: !matches!(data.reliability, Some(policy::Reliability::BestEffort)),
            transient_local: data
                .durability
                .is_some_and(|durability| durability != policy::Durability::Volatile),
            topic: data.topic_name,
            message: data.type_name,
        }
    })
    .collect()
}

/// The name of a topic of ROS 2 in DDS.
pub fn dds_name(topic: &str) -> String {
    format!("rt{topic}")
}
