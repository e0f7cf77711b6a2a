/// Each once, with how often it was there.
pub(super) fn counted(all: Vec<String>) -> Vec<String> {
    let mut times: Vec<(String, usize)> = Vec::new();
    for words in all {
        match times.iter_mut().find(|(known, _)| *known == words) {
            Some((_, count)) => *count += 1,
            None => times.push((words, 1)),
        }
    }
    let told = |(words, count): (String, usize)| {
        if count == 1 {
            words
        } else {
            format!("{words} ({count} times)")
        }
    };
    times.into_iter().map(told).collect()
}
