//! Which node may say what: each one for itself, to those that it speaks to.
//!
//! In: the names of the nodes. Out: zenoh's access control by the names in certificates. What a node sends to another one
//! goes under the key `mrroc/FROM/TO`, and `mrroc/alive/NODE` says that it is there. What comes in under `mrroc/b/..` is
//! taken from a connection whose certificate says `b`, and from no other one; so the receiver may believe the key.

use serde_json::{Value, json};

/// The key of what `from` sends to `to`.
pub(crate) fn way(from: &str, to: &str) -> String {
    format!("mrroc/{from}/{to}")
}

/// The key by which a node says that it is there.
pub(crate) fn alive(node: &str) -> String {
    // `alive` is no name of a node here: a node's own keys have its name in this place, and `@` is in no name.
    format!("mrroc/@alive/{node}")
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
        rules.push(rule("words", json!(["put"]), json!([way(other, me)])));
        rules.push(rule("life", json!(["liveliness_token"]), json!([alive(other)])));
        rules.push(rule("ears", json!(["declare_subscriber"]), json!([way(me, other)])));
        rules.push(rule(
            "sight",
            json!(["declare_liveliness_subscriber", "liveliness_query", "reply"]),
            json!(["mrroc/@alive/*"]),
        ));
        subjects.push(json!({ "id": other, "cert_common_names": [other] }));
        let of = |what: &str| format!("{what} of {other}");
        policies.push(
            json!({ "rules": [of("words"), of("life"), of("ears"), of("sight")], "subjects": [other] }),
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
