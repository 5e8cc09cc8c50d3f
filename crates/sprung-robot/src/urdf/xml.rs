//! Elements, attributes and numbers of the XML, with their lines for messages.

use std::cell::RefCell;

use roxmltree::{Document, Error, Node};

use super::error::UrdfError;

/// Largest number in a description: far above that of any robot, and sums of products of three
/// numbers stay finite.
const MAX_NUMBER: f64 = 1e30;

/// The text and its name.
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    text: &'a str,
    /// Ends of the lines, bytes.
    ends: Vec<usize>,
    /// Sentences about what the file says otherwise than a URDF should, without their last full stops.
    notes: RefCell<Vec<String>>,
}

impl<'a> Source<'a> {
    pub(super) fn new(file: &'a str, text: &'a str) -> Self {
        let ends = text.match_indices('\n').map(|(at, _)| at).collect();
        Self {
            file,
            text,
            ends,
            notes: RefCell::default(),
        }
    }

    /// Adds a sentence about what was read otherwise than it is written.
    pub(super) fn note(&self, note: String) {
        self.notes.borrow_mut().push(note);
    }

    /// Returns these sentences.
    pub(super) fn notes(&self) -> Vec<String> {
        self.notes.take()
    }

    /// Returns the line of a byte, from 1.
    fn line(&self, at: usize) -> usize {
        1 + self.ends.partition_point(|end| *end < at)
    }

    #[expect(clippy::wildcard_enum_match_arm, reason = "the reader has many errors")]
    pub(super) fn document(&self) -> Result<Document<'a>, UrdfError> {
        Document::parse(self.text).map_err(|error| {
            let position = error.pos().row as usize;
            let (line, reason) = match &error {
                Error::UnknownNamespace(prefix, _) if prefix == "xacro" => {
                    return self.xacro(position, "the prefix \"xacro:\"".to_owned());
                }
                Error::UnknownNamespace(prefix, _) => (
                    position,
                    format!(
                        "the prefix \"{prefix}:\" is not declared; remove its elements, or \
                         declare it in the first tag: <robot xmlns:{prefix}=\"{prefix}\" ...>"
                    ),
                ),
                Error::DtdDetected => (
                    self.line(self.text.find("<!DOCTYPE").unwrap_or(0)),
                    "a <!DOCTYPE ...> is not supported; remove it".to_owned(),
                ),
                // The text ends too early, and the parser gives no position.
                Error::UnclosedRootNode | Error::UnexpectedEndOfStream => (
                    self.line(self.text.trim_end().len()),
                    "the text ends before all tags are closed; is the file complete?".to_owned(),
                ),
                other => (
                    position,
                    format!("{other}; correct it or export the file again"),
                ),
            };
            UrdfError::Xml {
                file: self.file.to_owned(),
                line,
                reason,
            }
        })
    }

    fn xacro(&self, line: usize, what: String) -> UrdfError {
        UrdfError::Xacro {
            file: self.file.to_owned(),
            line,
            what,
        }
    }
}

/// An element and its name in messages.
pub(super) struct Element<'a, 'input> {
    node: Node<'a, 'input>,
    source: &'a Source<'a>,
    pub(super) called: String,
}

impl<'a, 'input> Element<'a, 'input> {
    pub(super) fn root(document: &'a Document<'input>, source: &'a Source<'a>) -> Self {
        let node = document.root_element();
        Self {
            node,
            source,
            called: format!("<{}>", node.tag_name().name()),
        }
    }

    pub(super) fn tag(&self) -> &'a str {
        self.node.tag_name().name()
    }

    pub(super) fn file(&self) -> String {
        self.source.file.to_owned()
    }

    pub(super) fn line(&self) -> usize {
        self.source.line(self.node.range().start)
    }

    /// Returns the children with a tag in the element's own namespace.
    pub(super) fn children<'t>(
        &self,
        tag: &'t str,
    ) -> impl Iterator<Item = Self> + use<'a, 'input, 't> {
        let (space, source) = (self.node.tag_name().namespace(), self.source);
        self.node
            .children()
            .filter(move |node| node.has_tag_name(tag) && node.tag_name().namespace() == space)
            .map(move |node| Self {
                node,
                source,
                called: format!("a <{tag}>"),
            })
    }

    /// Returns the only child with a tag, if it exists.
    pub(super) fn child(&self, tag: &'static str) -> Result<Option<Self>, UrdfError> {
        let mut found = self.children(tag);
        let first = found.next().map(|child| Self {
            called: format!("the <{tag}> of {}", self.called),
            ..child
        });
        match found.next() {
            None => Ok(first),
            // All readers of URDF take the first.
            Some(second) if tag == "origin" => {
                let (line, owner) = (second.line(), &self.called);
                let note = format!(
                    "line {line}: this is the second <origin> of {owner}; sprung takes the first"
                );
                self.source.note(note);
                Ok(first)
            }
            Some(second) => Err(UrdfError::Repeated {
                file: self.file(),
                line: second.line(),
                owner: self.called.clone(),
                element: tag,
            }),
        }
    }

    /// Returns the only child with a tag, which must exist.
    ///
    /// - `example`: an example of the child, for the message.
    pub(super) fn needed_child(
        &self,
        tag: &'static str,
        example: &'static str,
    ) -> Result<Self, UrdfError> {
        self.child(tag)?.ok_or_else(|| UrdfError::NoElement {
            file: self.file(),
            line: self.line(),
            owner: self.called.clone(),
            element: tag,
            example,
        })
    }

    pub(super) fn attribute(&self, key: &'static str) -> Result<Option<&'a str>, UrdfError> {
        match self.node.attribute(key) {
            Some(value) if value.contains("${") || value.contains("$(") => {
                Err(self.source.xacro(self.line(), format!("{key}=\"{value}\"")))
            }
            value => Ok(value),
        }
    }

    /// Returns an attribute, which must exist and must not be empty.
    pub(super) fn needed(&self, key: &'static str) -> Result<&'a str, UrdfError> {
        self.attribute(key)?
            .filter(|value| !value.trim().is_empty())
            .ok_or_else(|| UrdfError::NoAttribute {
                file: self.file(),
                line: self.line(),
                element: self.called.clone(),
                attribute: key,
            })
    }

    /// Returns an attribute, which must be a number.
    pub(super) fn number(&self, key: &'static str) -> Result<f64, UrdfError> {
        let value = self.needed(key)?;
        number(value)
            .filter(|number| number.abs() <= MAX_NUMBER)
            .ok_or_else(|| self.no_number(key, value))
    }

    /// Returns a limit; `None` if it is absent or infinite.
    pub(super) fn limit(&self, key: &'static str) -> Result<Option<f64>, UrdfError> {
        let Some(value) = self.attribute(key)? else {
            return Ok(None);
        };
        match number(value) {
            Some(limit) if !limit.is_nan() => {
                Ok(Some(limit).filter(|limit| limit.abs() <= MAX_NUMBER))
            }
            _ => Err(self.no_number(key, value)),
        }
    }

    /// Returns an attribute of three numbers, if it exists.
    pub(super) fn triple(&self, key: &'static str) -> Result<Option<[f64; 3]>, UrdfError> {
        let Some(value) = self.attribute(key)? else {
            return Ok(None);
        };
        let numbers: Option<Vec<f64>> = value
            .split_whitespace()
            .map(|word| number(word).filter(|number| number.abs() <= MAX_NUMBER))
            .collect();
        match numbers.as_deref() {
            Some(&[x, y, z]) => Ok(Some([x, y, z])),
            _ => Err(UrdfError::NoTriple {
                file: self.file(),
                line: self.line(),
                element: self.called.clone(),
                attribute: key,
                value: value.to_owned(),
            }),
        }
    }

    fn no_number(&self, key: &'static str, value: &str) -> UrdfError {
        UrdfError::NoNumber {
            file: self.file(),
            line: self.line(),
            element: self.called.clone(),
            attribute: key,
            value: value.to_owned(),
        }
    }

    /// Checks that the file contains no xacro macros.
    pub(super) fn refuse_xacro(&self) -> Result<(), UrdfError> {
        for node in self.node.descendants() {
            let Some(space) = node.tag_name().namespace() else {
                continue;
            };
            let is_xacro = |name: Option<&str>| name == Some("xacro");
            if space.contains("xacro")
                || (node.namespaces()).any(|known| is_xacro(known.name()) && known.uri() == space)
            {
                let line = self.source.line(node.range().start);
                let what = format!("<xacro:{}>", node.tag_name().name());
                return Err(self.source.xacro(line, what));
            }
        }
        Ok(())
    }
}

fn number(word: &str) -> Option<f64> {
    word.trim().parse().ok()
}
