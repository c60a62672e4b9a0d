//! Lists in the order of a number. A sort is a hundred functions for each type that is sorted: here all share those of one.

/// Sorts a list by a number, ascending; equals keep their order.
pub(crate) fn sort_by_number<T: Clone>(list: &mut [T], number: impl Fn(&T) -> f64) {
    let numbers: Vec<f64> = list.iter().map(number).collect();
    let sorted: Vec<T> = ascending(&numbers).into_iter().map(|place| list[place].clone()).collect();
    list.clone_from_slice(&sorted);
}

/// Places of numbers in their order, equals as they come.
fn ascending(numbers: &[f64]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..numbers.len()).collect();
    places.sort_by(|a, b| numbers[*a].total_cmp(&numbers[*b]));
    places
}

#[cfg(test)]
mod tests {
    #[test]
    fn equals_keep_their_order() {
        let mut list = [(2.0, 'a'), (-1.0, 'b'), (2.0, 'c'), (0.5, 'd'), (-1.0, 'e')];
        super::sort_by_number(&mut list, |(number, _)| *number);
        assert_eq!(list.map(|(_, name)| name), ['b', 'e', 'd', 'a', 'c']);
    }
}
