//! The pickle machine: a stack, a memo and a fixed list of opcodes. Source: Python's `pickletools`.

use super::class::Class;
use super::{Node, NodeId};
use crate::memory::{Allowance, Shortage};
use crate::numpy::{Place, ReadError};
use std::collections::HashMap;

/// Values that one pickle may hold: array contents are one value each.
const NODE_LIMIT: usize = 1 << 22;

/// A list that grows holds twice its length, and while it moves its old self too.
const GROWTH: usize = 3;
/// An entry of such a list of values.
const LIST_BYTES: usize = GROWTH * size_of::<NodeId>();
/// An entry of the memo.
const MEMO_BYTES: usize = GROWTH * 24;

/// Runs the opcodes up to STOP: all values, and which of them is the result.
pub(super) fn run<'a>(
    bytes: &'a [u8],
    file: &str,
    allowance: &Allowance,
) -> Result<(Vec<Node<'a>>, NodeId), ReadError> {
    let mut machine = Machine {
        file,
        allowance,
        bytes,
        at: 0,
        opcode_at: 0,
        nodes: Vec::new(),
        stack: Vec::new(),
        marks: Vec::new(),
        memo: HashMap::new(),
    };
    loop {
        machine.opcode_at = machine.at;
        let [opcode] = machine.take_word()?;
        if opcode == b'.' {
            let result = machine.pop()?;
            return Ok((machine.nodes, result));
        }
        machine.step(opcode)?;
    }
}

pub(super) struct Machine<'a, 'file> {
    file: &'file str,
    allowance: &'file Allowance,
    pub(super) bytes: &'a [u8],
    /// The next byte to read.
    pub(super) at: usize,
    /// The first byte of the current instruction.
    opcode_at: usize,
    nodes: Vec<Node<'a>>,
    stack: Vec<NodeId>,
    /// Heights of the stack where MARK was.
    marks: Vec<usize>,
    memo: HashMap<u64, NodeId>,
}

impl<'a> Machine<'a, '_> {
    fn step(&mut self, opcode: u8) -> Result<(), ReadError> {
        match opcode {
            // PROTO, FRAME
            0x80 => self.protocol(),
            0x95 => self.take_word::<8>().map(drop),
            // Numbers: NONE, NEWTRUE, NEWFALSE, BININT, BININT1, BININT2, BINFLOAT, LONG1, LONG4, INT, LONG, FLOAT
            b'N' => self.push(Node::None),
            0x88 => self.push(Node::Bool(true)),
            0x89 => self.push(Node::Bool(false)),
            b'J' => {
                let word = self.take_word()?;
                self.push(Node::Integer(i32::from_le_bytes(word).into()))
            }
            b'K' => {
                let word = self.take_word()?;
                self.push(Node::Integer(u8::from_le_bytes(word).into()))
            }
            b'M' => {
                let word = self.take_word()?;
                self.push(Node::Integer(u16::from_le_bytes(word).into()))
            }
            b'G' => {
                let word = self.take_word()?;
                self.push(Node::Float(f64::from_be_bytes(word)))
            }
            0x8a => self.binary_long::<1>(),
            0x8b => self.binary_long::<4>(),
            b'I' | b'L' => self.decimal_integer(),
            b'F' => self.decimal_float(),
            // Bytes: SHORT_BINBYTES, BINBYTES, BINBYTES8, BYTEARRAY8, SHORT_BINSTRING, BINSTRING, STRING
            b'C' | b'U' => self.binary_bytes::<1>(),
            b'B' | b'T' => self.binary_bytes::<4>(),
            0x8e | 0x96 => self.binary_bytes::<8>(),
            b'S' => self.quoted_bytes(),
            // Text: SHORT_BINUNICODE, BINUNICODE, BINUNICODE8, UNICODE
            0x8c => self.binary_text::<1>(),
            b'X' => self.binary_text::<4>(),
            0x8d => self.binary_text::<8>(),
            b'V' => self.escaped_text(),
            // Sequences: EMPTY_LIST, EMPTY_TUPLE, EMPTY_SET, LIST, TUPLE, FROZENSET, TUPLE1 to TUPLE3, APPEND,
            // APPENDS, ADDITEMS
            b']' | b')' | 0x8f => self.push(Node::Sequence(Vec::new())),
            b'l' | b't' | 0x91 => {
                let items = self.pop_to_mark()?;
                self.push(Node::Sequence(items))
            }
            0x85..=0x87 => {
                let items = self.pop_many(usize::from(opcode - 0x84))?;
                self.push(Node::Sequence(items))
            }
            b'a' => {
                let items = self.pop_many(1)?;
                self.append(items)
            }
            b'e' | 0x90 => {
                let items = self.pop_to_mark()?;
                self.append(items)
            }
            // Dictionaries: EMPTY_DICT, DICT, SETITEM, SETITEMS
            b'}' => self.push(Node::Dictionary(Vec::new())),
            b'd' => {
                let items = self.pop_to_mark()?;
                let items = self.pairs(items)?;
                self.push(Node::Dictionary(items))
            }
            b's' => {
                let items = self.pop_many(2)?;
                self.set_items(items)
            }
            b'u' => {
                let items = self.pop_to_mark()?;
                self.set_items(items)
            }
            // Objects: GLOBAL, STACK_GLOBAL, REDUCE, NEWOBJ, BUILD
            b'c' => {
                let (module, name) = (self.take_line()?, self.take_line()?);
                self.class(module, name)
            }
            0x93 => self.stack_class(),
            b'R' | 0x81 => self.call(),
            b'b' => self.build(),
            // The stack: MARK, POP, POP_MARK, DUP
            b'(' => {
                self.hold(LIST_BYTES)?;
                self.marks.push(self.stack.len());
                Ok(())
            }
            b'0' => self.pop().map(drop),
            b'1' => self.pop_to_mark().map(drop),
            b'2' => {
                let top = self.top()?;
                self.push_again(top)
            }
            // The memo: PUT, BINPUT, LONG_BINPUT, MEMOIZE, GET, BINGET, LONG_BINGET
            b'p' => {
                let key = self.decimal_key()?;
                self.remember(key)
            }
            b'q' => {
                let key = self.take_number::<1>()?;
                self.remember(key)
            }
            b'r' => {
                let key = self.take_number::<4>()?;
                self.remember(key)
            }
            0x94 => self.remember(self.memo.len() as u64),
            b'g' => {
                let key = self.decimal_key()?;
                self.recall(key)
            }
            b'h' => {
                let key = self.take_number::<1>()?;
                self.recall(key)
            }
            b'j' => {
                let key = self.take_number::<4>()?;
                self.recall(key)
            }
            other => Err(self.error("an opcode that pickled arrays use", format!("{other:#04x}"))),
        }
    }

    pub(super) fn error(&self, expected: impl Into<String>, found: impl Into<String>) -> ReadError {
        let field = format!("pickle byte {}", self.opcode_at);
        Place { file: self.file, field: &field }.error(expected, found)
    }

    // The stack.

    pub(super) fn push(&mut self, node: Node<'a>) -> Result<(), ReadError> {
        if self.nodes.len() == NODE_LIMIT {
            return Err(self.error(format!("at most {NODE_LIMIT} values"), "more"));
        }
        self.hold(GROWTH * size_of::<Node>())?;
        self.nodes.push(node);
        self.push_again(self.nodes.len() - 1)
    }

    /// A value that is there already, once more.
    fn push_again(&mut self, id: NodeId) -> Result<(), ReadError> {
        // On the stack, and in the list that it may go to.
        self.hold(2 * LIST_BYTES)?;
        self.stack.push(id);
        Ok(())
    }

    fn hold(&self, bytes: usize) -> Result<(), ReadError> {
        self.allowance.hold(bytes).map_err(|Shortage { expected, found }| self.error(expected, found))
    }

    /// Height below which nothing may be popped.
    fn floor(&self) -> usize {
        self.marks.last().copied().unwrap_or(0)
    }

    fn pop_many(&mut self, count: usize) -> Result<Vec<NodeId>, ReadError> {
        match self.stack.len().checked_sub(count).filter(|&start| start >= self.floor()) {
            Some(start) => Ok(self.stack.split_off(start)),
            None => Err(self.error(format!("{count} values on the stack"), "fewer")),
        }
    }

    fn pop(&mut self) -> Result<NodeId, ReadError> {
        Ok(self.pop_many(1)?[0])
    }

    fn pop_to_mark(&mut self) -> Result<Vec<NodeId>, ReadError> {
        match self.marks.pop() {
            Some(start) => Ok(self.stack.split_off(start)),
            None => Err(self.error("a mark on the stack", "none")),
        }
    }

    fn top(&self) -> Result<NodeId, ReadError> {
        match self.stack[self.floor()..].last() {
            Some(&top) => Ok(top),
            None => Err(self.error("a value on the stack", "none")),
        }
    }

    fn remember(&mut self, key: u64) -> Result<(), ReadError> {
        let top = self.top()?;
        self.hold(MEMO_BYTES)?;
        self.memo.insert(key, top);
        Ok(())
    }

    fn recall(&mut self, key: u64) -> Result<(), ReadError> {
        match self.memo.get(&key) {
            Some(&id) => self.push_again(id),
            None => Err(self.error("a value stored before", format!("nothing under {key}"))),
        }
    }

    // Containers.

    fn append(&mut self, items: Vec<NodeId>) -> Result<(), ReadError> {
        let target = self.top()?;
        match &mut self.nodes[target] {
            Node::Sequence(sequence) => {
                sequence.extend(items);
                Ok(())
            }
            other => {
                let found = other.description();
                Err(self.error("a list to append to", found))
            }
        }
    }

    fn pairs(&self, items: Vec<NodeId>) -> Result<Vec<(NodeId, NodeId)>, ReadError> {
        match items.as_chunks() {
            (pairs, []) => Ok(pairs.iter().map(|&[key, value]| (key, value)).collect()),
            _ => Err(self.error("a value for each key", format!("{} values in all", items.len()))),
        }
    }

    fn set_items(&mut self, items: Vec<NodeId>) -> Result<(), ReadError> {
        let pairs = self.pairs(items)?;
        let target = self.top()?;
        match &mut self.nodes[target] {
            Node::Dictionary(items) | Node::Object { items, .. } => {
                items.extend(pairs);
                Ok(())
            }
            other => {
                let found = other.description();
                Err(self.error("a dictionary to add to", found))
            }
        }
    }

    // Objects.

    fn class(&mut self, module: &str, name: &str) -> Result<(), ReadError> {
        match Class::named(module, name) {
            Some(class) => self.push(Node::Class(class)),
            None => Err(self.error(
                "only classes that carry arrays (numpy, scipy.sparse, chumpy)",
                format!("the class {}", format!("{module}.{name}").chars().take(80).collect::<String>()),
            )),
        }
    }

    fn stack_class(&mut self) -> Result<(), ReadError> {
        let ids = self.pop_many(2)?;
        match (self.nodes[ids[0]].as_short_text(), self.nodes[ids[1]].as_short_text()) {
            (Some(module), Some(name)) => {
                let (module, name) = (module.into_owned(), name.into_owned());
                self.class(&module, &name)
            }
            _ => Err(self.error("a module's and a class's name", "none")),
        }
    }

    fn call(&mut self) -> Result<(), ReadError> {
        let ids = self.pop_many(2)?;
        match (&self.nodes[ids[0]], &self.nodes[ids[1]]) {
            (&Node::Class(class), Node::Sequence(arguments)) => {
                // A call takes two bytes and its arguments may be long and shared: an honest one has few.
                if arguments.len() > 8 {
                    return Err(self.error("at most 8 arguments", format!("{}", arguments.len())));
                }
                let arguments = arguments.clone();
                self.push(Node::Object { class, arguments, state: None, items: Vec::new() })
            }
            (callable, _) => Err(self.error("a class and its arguments", callable.description())),
        }
    }

    fn build(&mut self) -> Result<(), ReadError> {
        let new_state = self.pop()?;
        let target = self.top()?;
        match &mut self.nodes[target] {
            Node::Object { state, .. } => {
                *state = Some(new_state);
                Ok(())
            }
            other => {
                let found = other.description();
                Err(self.error("an object to give its state to", found))
            }
        }
    }
}
