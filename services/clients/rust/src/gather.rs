//! Whole replies from their parts, whose samples stay where they are.

use bus::{CallError, Loan};
use schemas::convert;
use schemas::message::{self, ReplyAssembler};

use crate::error::Refused;
use crate::reply::{Block, Reply, Trajectory};

/// Puts one reply together.
#[derive(Debug, Default)]
pub(crate) struct Gatherer {
    assembler: ReplyAssembler,
    /// For each answer that has come, its samples.
    blocks: Vec<Vec<Block>>,
}

impl Gatherer {
    /// Whether nothing has come.
    pub(crate) fn is_empty(&self) -> bool {
        self.assembler.parts() == 0
    }

    /// Adds the next part, keeping it if its client may keep so many; returns the reply after the
    /// last.
    pub(crate) fn push(
        &mut self,
        loan: Loan,
        most_loans: usize,
    ) -> Result<Option<Result<Reply, Refused>>, CallError> {
        let (part, samples) = convert::read_part_in_place(loan.header(), loan.cells())?;
        let answer = part.answer as usize;
        let reply = self.assembler.push(part)?;
        // The assembler has seen that answers come in turn.
        if self.blocks.len() <= answer {
            self.blocks.resize_with(answer + 1, Vec::new);
        }
        if !samples.is_empty() {
            let count = samples.len();
            let block = match loan.alive() <= most_loans {
                true => Block::lent(loan, count),
                false => Block::copied(samples),
            };
            self.blocks[answer].push(block);
        }
        Ok(reply.map(|reply| self.whole(reply)))
    }

    fn whole(&mut self, reply: message::Reply) -> Result<Reply, Refused> {
        let message::Reply { key, id, answers } = reply;
        let blocks = std::mem::take(&mut self.blocks);
        let answers = answers?.into_iter().zip(blocks);
        let answers = answers.map(|(answer, blocks)| match answer {
            Ok(said) => Ok(Trajectory { said, blocks }),
            Err(refusal) => Err(refusal.into()),
        });
        Ok(Reply { key, id, answers: answers.collect() })
    }
}
