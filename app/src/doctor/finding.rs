//! Findings: what a check found and what it advises.

use std::fmt;

use serde_json::{Map, Value};

/// What a check found and, if something is missing, how to get it.
#[derive(Debug, Default)]
pub(super) struct Finding {
    items: Vec<Item>,
    /// Sentences; none if all is well.
    pub(super) advice: Vec<String>,
}

impl Finding {
    /// Adds something that is there.
    pub(super) fn found(&mut self, item: Item) {
        self.items.push(item);
    }

    /// Adds how to get something that is not.
    pub(super) fn advise(&mut self, advice: String) {
        self.advice.push(advice);
    }

    /// Whether nothing was found.
    pub(super) fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// The items, for programs.
    pub(super) fn json(&self) -> Value {
        self.items.iter().map(Item::json).collect()
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Item { name, detail, .. } in &self.items {
            let colon = if detail.is_empty() { "" } else { ": " };
            writeln!(f, "  {name}{colon}{detail}")?;
        }
        for advice in &self.advice {
            writeln!(f, "  → {}", advice.replace('\n', "\n    "))?;
        }
        Ok(())
    }
}

/// Something that is there.
#[derive(Debug)]
pub(super) struct Item {
    name: String,
    detail: String,
    facts: Map<String, Value>,
}

impl Item {
    /// `detail` is for people; `facts`, an object, say the same and more to programs.
    pub(super) fn new(name: impl Into<String>, detail: impl Into<String>, facts: Value) -> Self {
        let facts = match facts {
            Value::Object(facts) => facts,
            _ => Map::new(),
        };
        Self {
            name: name.into(),
            detail: detail.into(),
            facts,
        }
    }

    fn json(&self) -> Value {
        let mut object = self.facts.clone();
        object.insert("name".to_owned(), Value::from(self.name.as_str()));
        Value::Object(object)
    }
}
