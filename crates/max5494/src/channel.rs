//! Which of the part's two potentiometers a command is for.

/// One of the two potentiometers. A write is for one of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Channel {
    /// The first: pins H1, W1, L1.
    One,
    /// The second: pins H2, W2, L2.
    Two,
}

/// One of the two potentiometers, or both at once. A copy is for one or both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Channels {
    /// The first alone.
    One,
    /// The second alone.
    Two,
    /// Both, in one command.
    Both,
}

impl From<Channel> for Channels {
    fn from(channel: Channel) -> Self {
        match channel {
            Channel::One => Self::One,
            Channel::Two => Self::Two,
        }
    }
}
