//! Keeps a bounded number of samples of a stream with unknown length.

/// Keeps every s-th item; `s` doubles whenever the limit is reached.
#[derive(Clone, Debug)]
pub(crate) struct Decimator<T> {
    kept: Vec<T>,
    limit: usize,
    stride: u64,
    // Items to pass over before the next one that may be kept.
    ahead: u64,
}

impl<T> Decimator<T> {
    /// Returns an empty decimator that never holds more than `limit` items.
    #[must_use]
    pub(crate) fn new(limit: usize) -> Self {
        Self {
            kept: Vec::new(),
            limit: limit.max(2),
            stride: 1,
            ahead: 0,
        }
    }

    /// Takes the next item; `item` is called only if it is kept.
    pub(crate) fn push(&mut self, item: impl FnOnce() -> T) {
        if self.ahead > 0 {
            self.ahead -= 1;
            return;
        }
        if self.kept.len() == self.limit {
            let mut index = 0;
            self.kept.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride *= 2;
            // With an odd limit this item lies halfway between two that are kept.
            if self.limit % 2 == 1 {
                self.ahead = self.stride / 2 - 1;
                return;
            }
        }
        self.kept.push(item());
        self.ahead = self.stride - 1;
    }

    /// Returns the distance of the kept items among all items.
    #[must_use]
    pub(crate) fn stride(&self) -> u64 {
        self.stride
    }

    /// Returns the kept items, oldest first.
    #[must_use]
    pub(crate) fn items(&self) -> &[T] {
        &self.kept
    }

    /// Returns the kept items, oldest first.
    #[must_use]
    pub(crate) fn into_items(self) -> Vec<T> {
        self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_evenly_spaced_and_bounded() {
        for length in [1_u64, 5, 10, 11, 1000, 4097] {
            let mut decimator = Decimator::new(10);
            for k in 0..length {
                decimator.push(|| k);
            }
            let items = decimator.into_items();
            assert!(items.len() <= 10 && items[0] == 0);
            if let [a, b, ..] = items[..] {
                assert!(items.windows(2).all(|w| w[1] - w[0] == b - a));
            }
            assert!(length < 10 || items.len() >= 5);
        }
    }
}
