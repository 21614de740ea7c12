//! Validation against JSON Schemas, for the tests of what the program reads and writes.

use serde_json::Value;

/// Checks `value` against the part of JSON Schema that this project uses; an unknown keyword is a fault as well.
pub fn validate(value: &Value, schema: &Value, root: &Value, place: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let fault = |what: String| format!("{place}: {what}");
    let keywords = schema.as_object().unwrap();
    for (keyword, rule) in keywords {
        match keyword.as_str() {
            "$ref" => {
                let target = root.pointer(rule.as_str().unwrap().trim_start_matches('#')).expect("a definition");
                faults.extend(validate(value, target, root, place));
                return faults;
            }
            "type" => {
                let names: Vec<&str> = rule
                    .as_array()
                    .map_or(vec![rule.as_str().unwrap_or("")], |all| all.iter().filter_map(Value::as_str).collect());
                let is = |name: &str| match name {
                    "string" => value.is_string(),
                    "number" => value.is_number(),
                    "integer" => value.is_u64() || value.is_i64(),
                    "boolean" => value.is_boolean(),
                    "null" => value.is_null(),
                    "array" => value.is_array(),
                    "object" => value.is_object(),
                    _ => panic!("unknown type {name}"),
                };
                if !names.into_iter().any(is) {
                    faults.push(fault(format!("{value} is not of type {rule}")));
                }
            }
            "const" if value != rule => faults.push(fault(format!("{value} is not {rule}"))),
            "enum" if !rule.as_array().unwrap().contains(value) => {
                faults.push(fault(format!("{value} is none of {rule}")))
            }
            "minimum" if value.as_f64().is_some_and(|x| x < rule.as_f64().unwrap()) => {
                faults.push(fault(format!("{value} is below {rule}")));
            }
            "maximum" if value.as_f64().is_some_and(|x| x > rule.as_f64().unwrap()) => {
                faults.push(fault(format!("{value} is above {rule}")));
            }
            "if" => {
                let branch = if validate(value, rule, root, place).is_empty() { "then" } else { "else" };
                if let Some(schema) = keywords.get(branch) {
                    faults.extend(validate(value, schema, root, place));
                }
            }
            "not" if validate(value, rule, root, place).is_empty() => faults.push(fault(format!("fits {rule}"))),
            "oneOf" | "anyOf" => {
                let fits =
                    rule.as_array().unwrap().iter().filter(|s| validate(value, s, root, place).is_empty()).count();
                if fits == 0 || (keyword == "oneOf" && fits > 1) {
                    faults.push(fault(format!("fits {fits} of {rule}")));
                }
            }
            "prefixItems" => {
                for (i, (item, schema)) in
                    value.as_array().into_iter().flatten().zip(rule.as_array().unwrap()).enumerate()
                {
                    faults.extend(validate(item, schema, root, &format!("{place}/{i}")));
                }
            }
            "minItems" | "maxItems" => {
                let (n, limit) = (value.as_array().map_or(0, Vec::len), rule.as_u64().unwrap() as usize);
                if (keyword == "minItems" && n < limit) || (keyword == "maxItems" && n > limit) {
                    faults.push(fault(format!("{n} items, {keyword} {limit}")));
                }
            }
            "required" => {
                for name in rule.as_array().unwrap().iter().filter_map(Value::as_str) {
                    if value.get(name).is_none() {
                        faults.push(fault(format!("{name} is missing")));
                    }
                }
            }
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    faults.extend(validate(item, rule, root, &format!("{place}/{i}")));
                }
            }
            "properties" | "additionalProperties" | "then" | "else" | "not" => {}
            "const" | "enum" | "minimum" | "maximum" | "pattern" | "default" | "description" | "title" | "$schema"
            | "$defs" => {}
            other => panic!("the test does not know the keyword {other}"),
        }
    }
    for (name, inside) in value.as_object().into_iter().flatten() {
        let place = format!("{place}/{name}");
        match (keywords.get("properties").and_then(|p| p.get(name)), keywords.get("additionalProperties")) {
            (Some(schema), _) => faults.extend(validate(inside, schema, root, &place)),
            (None, Some(Value::Bool(false))) => faults.push(format!("{place}: not in the schema")),
            (None, Some(schema @ Value::Object(_))) => faults.extend(validate(inside, schema, root, &place)),
            _ => {}
        }
    }
    faults
}
