"""The compact construction, the default: one small one-sided transducer for each temporal operator."""
