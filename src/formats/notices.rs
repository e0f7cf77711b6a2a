/// Each notice once; `several` makes one of a notice that occurs several times.
pub(super) fn counted<N: PartialEq>(all: Vec<N>, several: impl Fn(N, usize) -> N) -> Vec<N> {
    let mut times: Vec<(N, usize)> = Vec::new();
    for notice in all {
        match times.iter_mut().find(|(known, _)| *known == notice) {
            Some((_, count)) => *count += 1,
            None => times.push((notice, 1)),
        }
    }
    let merged = times.into_iter().map(|(notice, count)| match count {
        1 => notice,
        _ => several(notice, count),
    });
    merged.collect()
}
