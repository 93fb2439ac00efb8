//! Batches decoded ahead of who takes them, on a thread of their own: decoding takes as long as what is done with the rows.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

/// Batches that wait, at most: memory stays bounded however slow the taker is.
const WAITING: usize = 4;

/// The same items, each made before it is asked for. Where there are no threads, as in a page, they are made when asked for.
pub(super) fn ahead<T: Send + 'static>(items: impl Iterator<Item = T> + Send + 'static) -> Box<dyn Iterator<Item = T>> {
    if cfg!(target_family = "wasm") {
        return Box::new(items);
    }
    let (sender, receiver) = sync_channel(WAITING);
    let (hand_over, handed) = sync_channel(1);
    let make = move || {
        if let Ok(items) = handed.recv() {
            send_all(items, &sender);
        }
    };
    match Builder::new().name("decoding".to_owned()).spawn(make) {
        Ok(maker) => {
            // It waits for them.
            let _ = hand_over.send(items);
            Box::new(Ahead { receiver, maker: Some(maker) })
        }
        Err(_) => Box::new(items),
    }
}

/// Sends until nobody takes any more.
fn send_all<T>(items: impl Iterator<Item = T>, sender: &SyncSender<T>) {
    for item in items {
        if sender.send(item).is_err() {
            return;
        }
    }
}

struct Ahead<T> {
    receiver: Receiver<T>,
    maker: Option<JoinHandle<()>>,
}

impl<T> Iterator for Ahead<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        if let Ok(item) = self.receiver.recv() {
            return Some(item);
        }
        // The end, or a panic, which must not pass for the end.
        if let Some(Err(panic)) = self.maker.take().map(JoinHandle::join) {
            std::panic::resume_unwind(panic);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_come_in_order_and_end() {
        assert_eq!(ahead(0..1000).collect::<Vec<_>>(), (0..1000).collect::<Vec<_>>());
        assert_eq!(ahead(std::iter::empty::<u8>()).count(), 0);
        let mut taken = ahead(0..3);
        taken.by_ref().for_each(drop);
        assert_eq!((taken.next(), taken.next()), (None, None));
    }

    #[test]
    fn no_more_are_made_than_wait_and_none_after_the_taker_has_gone() {
        use std::sync::Arc;
        use std::sync::atomic::{AtomicUsize, Ordering};
        let made = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&made);
        let count = move |_: &i32| {
            counted.fetch_add(1, Ordering::SeqCst);
        };
        let mut items = ahead((0..1_000_000).inspect(count));
        assert_eq!(items.next(), Some(0));
        drop(items);
        // One taken, those that waited, and one in the maker's hand.
        assert!(made.load(Ordering::SeqCst) <= WAITING + 2);
    }

    #[test]
    #[should_panic(expected = "a fault of the decoder")]
    fn a_panic_is_no_end() {
        let items = ahead((0..10).inspect(|item| assert!(*item < 5, "a fault of the decoder")));
        assert!(items.count() > 10);
    }
}
