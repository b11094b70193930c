//! Replies on the way back: unchanged, lost, duplicated, delayed.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    Sound,
    Lost,
    Twice,
    /// Sent `frames` later, before the reply of that frame or after it (out of order).
    Late {
        frames: u64,
        after: bool,
    },
}

#[derive(Default)]
pub struct Replies {
    delayed: Vec<(u64, bool, Vec<u8>)>,
    count: u64,
}

impl Replies {
    /// Takes the reply to one frame; replies that are due are added to `out`.
    pub fn take(&mut self, frame: Vec<u8>, fate: Fate, out: &mut Vec<Vec<u8>>) {
        self.count += 1;
        self.release(false, out);
        match fate {
            Fate::Sound => out.push(frame),
            Fate::Lost => {}
            Fate::Twice => out.extend([frame.clone(), frame]),
            Fate::Late { frames, after } => self.delayed.push((self.count + frames, after, frame)),
        }
        self.release(true, out);
    }

    fn release(&mut self, after: bool, out: &mut Vec<Vec<u8>>) {
        let count = self.count;
        let due = |delayed: &(u64, bool, Vec<u8>)| delayed.0 <= count && delayed.1 == after;
        out.extend(
            self.delayed.iter().filter(|delayed| due(delayed)).map(|delayed| delayed.2.clone()),
        );
        self.delayed.retain(|delayed| !due(delayed));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(fates: &[Fate]) -> Vec<Vec<u8>> {
        let mut replies = Replies::default();
        let send = |(k, fate): (usize, &Fate)| {
            let mut out = Vec::new();
            replies.take(vec![k as u8], *fate, &mut out);
            out.concat()
        };
        fates.iter().enumerate().map(send).collect()
    }

    #[test]
    fn replies_come_when_their_fate_says() {
        use Fate::{Late, Lost, Sound, Twice};
        assert_eq!(sent(&[Sound, Lost, Twice]), [vec![0], vec![], vec![2, 2]]);
        let late = Late { frames: 2, after: false };
        assert_eq!(sent(&[late, Sound, Sound]), [vec![], vec![1], vec![0, 2]]);
        let after = Late { frames: 1, after: true };
        assert_eq!(sent(&[after, Sound]), [vec![], vec![1, 0]]);
    }
}
