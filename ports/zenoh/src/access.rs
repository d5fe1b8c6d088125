//! Which node may say what: each one for itself, to those that it speaks to.
//!
//! In: the names of the nodes. Out: zenoh's access control by the names in certificates. What a node sends to another one
//! goes under the key `mrroc/FROM/TO`, and `mrroc/alive/NODE` says that it is there. What comes in under `mrroc/b/..` is
//! taken from a connection whose certificate says `b`, and from no other one; so the receiver may believe the key.

use serde_json::{Value, json};

use crate::certificates::program;

/// The key of what `from` sends to `to`.
pub(crate) fn sent(from: &str, to: &str) -> String {
    format!("mrroc/{from}/{to}")
}

/// The key by which a node says that it is there.
pub(crate) fn alive(node: &str) -> String {
    // `alive` is no name of a node here: a node's own keys have its name in this place, and `@` is in no name.
    format!("mrroc/@alive/{node}")
}

/// The key below which everything of a sensor's gateway is.
fn of_sensor(sensor: &str) -> String {
    // `@sensor` is in no name of a node.
    format!("mrroc/@sensor/{sensor}")
}

/// The keys of a gateway: the orders of the cell, the readings of the program, and the programs that are there.
pub(crate) struct GatewayKeys {
    pub orders: String,
    pub readings: String,
    /// Without the program's number.
    pub programs: String,
}

impl GatewayKeys {
    pub fn of(sensor: &str) -> GatewayKeys {
        let base = of_sensor(sensor);
        let key = |last: &str| format!("{base}/{last}");
        GatewayKeys { orders: key("orders"), readings: key("readings"), programs: key("@program") }
    }
}

/// The rules of the gateway of a sensor: it hears who has the certificate of that sensor's program, and nobody else.
pub(crate) fn at_gateway(sensor: &str) -> Value {
    let GatewayKeys { orders, readings, programs } = GatewayKeys::of(sensor);
    let programs = format!("{programs}/*");
    let rule = |id: &str, flow: &str, messages: Value, keys: Value| json!({ "id": id, "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": keys });
    json!({
        "enabled": true,
        "default_permission": "deny",
        "rules": [
            rule("orders", "egress", json!(["put"]), json!([orders])),
            rule("subscriptions", "egress", json!(["declare_subscriber", "declare_liveliness_subscriber", "liveliness_query"]),
                json!([readings, programs])),
            rule("words", "ingress", json!(["put"]), json!([readings])),
            rule("liveliness", "ingress", json!(["liveliness_token", "reply"]), json!([programs])),
            rule("its subscriptions", "ingress", json!(["declare_subscriber"]), json!([orders])),
        ],
        "subjects": [
            { "id": "program", "cert_common_names": [program(sensor)] },
        ],
        "policies": [
            { "rules": ["orders", "subscriptions", "words", "liveliness", "its subscriptions"], "subjects": ["program"] },
        ],
    })
}

/// The rules of the node `me`, among the others.
pub(crate) fn control<'a>(me: &str, others: impl Iterator<Item = &'a str> + Clone) -> Value {
    let mut rules = vec![json!({
        "id": "out",
        "permission": "allow",
        "flows": ["egress"],
        "messages": ["put", "declare_subscriber", "liveliness_token", "declare_liveliness_subscriber", "liveliness_query", "reply"],
        "key_exprs": ["mrroc/**", "mrroc/@alive/*"],
    })];
    let mut subjects = vec![json!({ "id": "anybody" })];
    let mut policies = vec![json!({ "rules": ["out"], "subjects": ["anybody"] })];
    for other in others {
        let rule = |what: &str, messages: Value, keys: Value| {
            json!({
                "id": format!("{what} of {other}"),
                "permission": "allow",
                "flows": ["ingress"],
                "messages": messages,
                "key_exprs": keys,
            })
        };
        rules.push(rule("words", json!(["put"]), json!([sent(other, me)])));
        rules.push(rule("liveliness", json!(["liveliness_token"]), json!([alive(other)])));
        rules.push(rule("subscriptions", json!(["declare_subscriber"]), json!([sent(me, other)])));
        rules.push(rule(
            "presence",
            json!(["declare_liveliness_subscriber", "liveliness_query", "reply"]),
            json!(["mrroc/@alive/*"]),
        ));
        subjects.push(json!({ "id": other, "cert_common_names": [other] }));
        let of = |what: &str| format!("{what} of {other}");
        policies.push(
            json!({ "rules": [of("words"), of("liveliness"), of("subscriptions"), of("presence")], "subjects": [other] }),
        );
    }
    json!({
        "enabled": true,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    })
}
