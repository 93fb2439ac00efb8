//! The circles of a graph: its strongly connected components.

use std::collections::BTreeMap;

/// The groups of more than one node in which each leads to each other, by Tarjan's algorithm (SIAM J. Comput. 1(2), 1972).
/// `arrows[a]` are the nodes that `a` leads to. Nodes are sorted within a group.
pub fn circles(arrows: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut search = Search { arrows, ..Search::default() };
    for node in 0..arrows.len() {
        if !search.found.contains_key(&node) {
            search.visit(node);
        }
    }
    search.circles
}

#[derive(Default)]
struct Search<'a> {
    arrows: &'a [Vec<usize>],
    /// When each node was found, and the earliest node on the path that is reached from it.
    found: BTreeMap<usize, (usize, usize)>,
    path: Vec<usize>,
    circles: Vec<Vec<usize>>,
}

impl Search<'_> {
    /// Returns the earliest node that is reached.
    fn visit(&mut self, node: usize) -> usize {
        let order = self.found.len();
        self.found.insert(node, (order, order));
        self.path.push(node);
        let mut earliest = order;
        for &next in &self.arrows[node] {
            let reached = match self.found.get(&next) {
                None => self.visit(next),
                Some((order, _)) if self.path.contains(&next) => *order,
                Some(_) => continue,
            };
            earliest = earliest.min(reached);
        }
        self.found.insert(node, (order, earliest));
        if earliest == order {
            let began = self.path.iter().position(|on_path| *on_path == node).unwrap_or(0);
            let mut circle = self.path.split_off(began);
            circle.sort_unstable();
            if circle.len() > 1 {
                self.circles.push(circle);
            }
        }
        earliest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_circle_is_found_whole_and_what_only_leads_to_one_is_none_of_it() {
        // 0 -> 1 -> 2 -> 0, 3 -> 0, 4 <-> 5, 2 -> 4.
        assert_eq!(circles(&[vec![1], vec![2], vec![0, 4], vec![0], vec![5], vec![4]]), [vec![4, 5], vec![0, 1, 2]]);
        assert_eq!(circles(&[vec![1, 2], vec![3], vec![3], vec![]]), [[0; 0]; 0]);
        // Two circles through one node are one.
        assert_eq!(circles(&[vec![1, 2], vec![0], vec![0]]), [[0, 1, 2]]);
    }
}
