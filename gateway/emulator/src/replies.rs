//! Replies on their way back: sound, lost, twice, late.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    Sound,
    Lost,
    Twice,
    /// Sent with the reply of so many frames later: before it, or after it (out of order).
    Late {
        frames: u64,
        after: bool,
    },
}

#[derive(Default)]
pub struct Replies {
    held: Vec<(u64, bool, Vec<u8>)>,
    count: u64,
}

impl Replies {
    /// One frame's reply; what is to be sent now is added to `out`.
    pub fn take(&mut self, frame: Vec<u8>, fate: Fate, out: &mut Vec<Vec<u8>>) {
        self.count += 1;
        self.release(false, out);
        match fate {
            Fate::Sound => out.push(frame),
            Fate::Lost => {}
            Fate::Twice => out.extend([frame.clone(), frame]),
            Fate::Late { frames, after } => self.held.push((self.count + frames, after, frame)),
        }
        self.release(true, out);
    }

    fn release(&mut self, after: bool, out: &mut Vec<Vec<u8>>) {
        let count = self.count;
        let due = |held: &(u64, bool, Vec<u8>)| held.0 <= count && held.1 == after;
        out.extend(self.held.iter().filter(|held| due(held)).map(|held| held.2.clone()));
        self.held.retain(|held| !due(held));
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
