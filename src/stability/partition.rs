//! Things sorted into classes, by being told which belong together.

/// A partition of 0..n (disjoint sets with path halving). The class of an element is its least member, so the result
/// depends only on which elements were joined, not on the order of joining.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Partition(Vec<usize>);

impl Partition {
    /// Everyone alone.
    pub(super) fn singles(n: usize) -> Self {
        Self((0..n).collect())
    }

    /// Elements with equal keys together.
    pub(super) fn by_key<K: Ord>(keys: &[K]) -> Self {
        let mut partition = Self::singles(keys.len());
        let mut order: Vec<usize> = (0..keys.len()).collect();
        order.sort_by_key(|&index| &keys[index]);
        for pair in order.windows(2) {
            if keys[pair[0]] == keys[pair[1]] {
                partition.join(pair[0], pair[1]);
            }
        }
        partition
    }

    /// The class of an element.
    pub(super) fn class(&self, mut element: usize) -> usize {
        while self.0[element] != element {
            element = self.0[element];
        }
        element
    }

    pub(super) fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (self.class(one), self.class(other));
        self.0[one.max(other)] = one.min(other);
    }

    /// Whether all elements are of one class.
    pub(super) fn is_whole(&self) -> bool {
        (1..self.0.len()).all(|element| self.class(element) == self.class(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joining_is_transitive_and_the_least_member_names_the_class() {
        let mut partition = Partition::singles(5);
        partition.join(4, 2);
        partition.join(2, 1);
        let classes: Vec<usize> = (0..5).map(|element| partition.class(element)).collect();
        assert_eq!(classes, [0, 1, 1, 3, 1]);
        assert!(!partition.is_whole());
    }

    #[test]
    fn equal_keys_are_one_class() {
        let partition = Partition::by_key(&["b", "a", "b", "c", "a"]);
        let classes: Vec<usize> = (0..5).map(|element| partition.class(element)).collect();
        assert_eq!(classes, [0, 1, 0, 3, 1]);
    }
}
