//! A port that a driver owns while a test, or a bench, looks at the board.

use core::convert::Infallible;
use std::cell::RefCell;
use std::rc::Rc;

use embedded_hal::spi::{ErrorType, Operation, SpiDevice};

use crate::master::Port;

/// A handle on a port.
#[derive(Debug, Clone)]
pub struct SharedPort(pub Rc<RefCell<Port>>);

impl SharedPort {
    /// The first handle.
    #[must_use]
    pub fn new(port: Port) -> Self {
        Self(Rc::new(RefCell::new(port)))
    }
}

impl ErrorType for SharedPort {
    type Error = Infallible;
}

impl SpiDevice for SharedPort {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        self.0.borrow_mut().transaction(operations)
    }
}
