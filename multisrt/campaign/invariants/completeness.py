def complete_is_complete(run): return None
def boxed_in_is_boxed_in(run): return None
