//! In which order images are eliminated: one that fills few tiles of the factor.
//!
//! Images are gathered in groups, one a row and column of tiles, either by their numbers, which often follow the path of the camera,
//! or by nearness (Cuthill and McKee, Reducing the bandwidth of sparse symmetric matrices, 1969). Groups are eliminated in that order,
//! or each time the one that has fewest neighbours left (Tinney and Walker, 1967). Of the four what costs least is taken.

/// Which nodes are neighbours: a row of bits for each. A million images would need too much, but so would all else.
#[derive(Debug, Clone)]
pub(super) struct Graph {
    rows: Vec<Vec<u64>>,
}

impl Graph {
    pub(super) fn new(nodes: usize) -> Self {
        Self { rows: vec![vec![0; nodes.div_ceil(64)]; nodes] }
    }

    pub(super) fn nodes(&self) -> usize {
        self.rows.len()
    }

    pub(super) fn join(&mut self, one: usize, other: usize) {
        if one != other {
            self.rows[one][other / 64] |= 1 << (other % 64);
            self.rows[other][one / 64] |= 1 << (one % 64);
        }
    }

    /// Ascending.
    pub(super) fn neighbours(&self, node: usize) -> Vec<usize> {
        let mut found = Vec::new();
        for (word, &bits) in self.rows[node].iter().enumerate() {
            let mut bits = bits;
            while bits != 0 {
                found.push(64 * word + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
        found
    }

    fn degree(&self, node: usize) -> usize {
        self.rows[node].iter().map(|bits| bits.count_ones() as usize).sum()
    }

    /// The graph of groups of so many nodes that follow each other in this order.
    pub(super) fn grouped(&self, order: &[usize], size: usize) -> Self {
        let mut group_of = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, &node)| group_of[node] = place / size);
        let mut groups = Self::new(order.len().div_ceil(size));
        for &node in order {
            for other in self.neighbours(node) {
                groups.join(group_of[node], group_of[other]);
            }
        }
        groups
    }

    /// With so many nodes more, at the end, which are joined with none.
    pub(super) fn enlarged(&self, more: usize) -> Self {
        let mut enlarged = Self::new(self.nodes() + more);
        for (row, bits) in enlarged.rows.iter_mut().zip(&self.rows) {
            row[..bits.len()].copy_from_slice(bits);
        }
        enlarged
    }

    /// Takes a node out; its neighbours, which it leaves joined, are the rows below it in the factor.
    pub(super) fn eliminate(&mut self, node: usize) -> Vec<usize> {
        let below = self.neighbours(node);
        let taken = std::mem::take(&mut self.rows[node]);
        for &other in &below {
            for (bits, more) in self.rows[other].iter_mut().zip(&taken) {
                *bits |= more;
            }
            self.rows[other][node / 64] &= !(1 << (node % 64));
            self.rows[other][other / 64] &= !(1 << (other % 64));
        }
        below
    }

    /// Breadth first, from nodes at the rim.
    fn by_nearness(&self) -> Vec<usize> {
        let mut order = Vec::with_capacity(self.nodes());
        let mut is_placed = vec![false; self.nodes()];
        for node in 0..self.nodes() {
            if !is_placed[node] {
                let outermost = self.breadth_first(node, &mut is_placed.clone());
                let rim = outermost.last().copied().unwrap_or(node);
                order.extend(self.breadth_first(rim, &mut is_placed));
            }
        }
        order
    }

    fn breadth_first(&self, start: usize, is_placed: &mut [bool]) -> Vec<usize> {
        let mut order = vec![start];
        is_placed[start] = true;
        let mut at = 0;
        while at < order.len() {
            let mut next = self.neighbours(order[at]);
            next.retain(|&node| !is_placed[node]);
            next.sort_by_key(|&node| self.degree(node));
            next.iter().for_each(|&node| is_placed[node] = true);
            order.extend(next);
            at += 1;
        }
        order
    }
}

/// The order of the images, of which so many at a time make a group.
pub(super) fn ordered(images: &Graph, group: usize) -> Vec<usize> {
    let by_number: Vec<usize> = (0..images.nodes()).collect();
    let mut best: Option<(usize, Vec<usize>)> = None;
    for order in [by_number, images.by_nearness()] {
        let groups = images.grouped(&order, group);
        let as_they_come = (0..groups.nodes()).collect();
        for sequence in [as_they_come, fewest_neighbours_first(groups.clone())] {
            let cost = products(groups.clone(), &sequence);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, by_groups(&order, &sequence, group)));
            }
        }
    }
    best.map(|(_, order)| order).unwrap_or_default()
}

fn fewest_neighbours_first(mut graph: Graph) -> Vec<usize> {
    let mut degrees: Vec<usize> = (0..graph.nodes()).map(|node| graph.degree(node)).collect();
    let mut left: Vec<usize> = (0..graph.nodes()).collect();
    let mut order = Vec::with_capacity(left.len());
    while let Some(at) = (0..left.len()).min_by_key(|&at| degrees[left[at]]) {
        // The first of equals, so that neighbours in number stay neighbours.
        let node = left.remove(at);
        for other in graph.eliminate(node) {
            degrees[other] = graph.degree(other);
        }
        order.push(node);
    }
    order
}

/// How many products of tiles a factorisation in this order takes.
fn products(mut graph: Graph, order: &[usize]) -> usize {
    let of_one = |&node: &usize| {
        let below = graph.eliminate(node).len();
        (below + 1) * (below + 2) / 2
    };
    order.iter().map(of_one).sum()
}

/// The nodes group by group; the group that is not full goes last, so that the others begin where a tile does.
fn by_groups(order: &[usize], sequence: &[usize], size: usize) -> Vec<usize> {
    let groups: Vec<&[usize]> = order.chunks(size).collect();
    let (full, rest): (Vec<&[usize]>, Vec<&[usize]>) =
        sequence.iter().map(|&group| groups[group]).partition(|group| group.len() == size);
    full.into_iter().chain(rest).flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each joined with so many that follow, under shuffled numbers.
    fn shuffled_path(nodes: usize, reach: usize, is_closed: bool) -> Graph {
        let mut graph = Graph::new(nodes);
        // 37 has no factor in common with the counts below.
        let number = |place: usize| place * 37 % nodes;
        for place in 0..nodes {
            for other in place + 1..=place + reach {
                if is_closed || other < nodes {
                    graph.join(number(place), number(other % nodes));
                }
            }
        }
        graph
    }

    fn cost(graph: &Graph, group: usize) -> usize {
        let order = ordered(graph, group);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..graph.nodes()).collect::<Vec<_>>());
        let groups = graph.grouped(&order, group);
        products(groups.clone(), &(0..groups.nodes()).collect::<Vec<_>>())
    }

    #[test]
    fn a_path_under_any_numbers_fills_little() {
        // In order of the path a group of 8 meets two others at most, of reach 10: 800 / 8 columns of 3 tiles or less.
        assert!(cost(&shuffled_path(800, 10, false), 8) <= 100 * 6);
        // A ring has two ends to hold at any time.
        assert!(cost(&shuffled_path(800, 10, true), 8) <= 100 * 21);
    }

    #[test]
    fn a_star_is_eliminated_before_its_centre() {
        let mut graph = Graph::new(200);
        (1..200).for_each(|leaf| graph.join(0, leaf));
        let order = ordered(&graph, 1);
        assert!(order.iter().position(|&node| node == 0).unwrap() >= 198);
        assert_eq!(cost(&graph, 1), 199 * 3 + 1);
    }

    #[test]
    fn eliminating_joins_what_is_left() {
        let mut graph = Graph::new(70);
        for (one, other) in [(3, 1), (3, 69), (3, 40), (1, 2)] {
            graph.join(one, other);
        }
        assert_eq!(graph.eliminate(3), [1, 40, 69]);
        assert_eq!(graph.neighbours(1), [2, 40, 69]);
        assert_eq!(graph.neighbours(40), [1, 69]);
        assert_eq!(graph.eliminate(40), [1, 69]);
        assert_eq!(graph.neighbours(69), [1]);
    }
}
